//! Packing and missing data by the CF conventions, as attributes of a variable (<https://cfconventions.org>, 2.5.1 and 8.1).

use crate::error::Error;
use crate::volume::missing_data::MissingData;
use crate::volume::{Rescale, ScalarType};

/// The attributes of a variable.
pub(super) trait Attributes {
    /// The numbers of an attribute, if it has such, and whether they are stored as floats.
    fn numbers(&self, name: &str) -> Option<(Vec<f64>, bool)>;

    /// The text of an attribute.
    fn text(&self, name: &str) -> Option<String>;
}

/// What the stored numbers of a variable mean.
#[derive(Debug)]
pub(super) struct Packed {
    /// Their type, with the sign that `_Unsigned` states.
    pub scalar: ScalarType,
    pub rescale: Rescale,
    pub missing: MissingData,
}

/// Attributes whose numbers stand for missing voxels.
const FILL_VALUES: [&str; 2] = ["_FillValue", "missing_value"];
/// Limit by which bounds in units of values may be off when they are converted to stored whole numbers.
const ROUNDING: f64 = 1e-6;

/// Evaluates the attributes of numbers of type `stored`. `default_fill` stands for missing voxels if no attribute states a fill value.
///
/// # Errors
/// [`Error::OutOfRange`] for a slope or intercept that cannot be used.
pub(super) fn packed(stored: ScalarType, attributes: &dyn Attributes, default_fill: Option<f64>) -> Result<Packed, Error> {
    let first = |name: &str| attributes.numbers(name).and_then(|(numbers, _)| numbers.first().copied());
    let rescale = match (first("scale_factor"), first("add_offset")) {
        (None, None) => None,
        (slope, intercept) => Some(Rescale::new(slope.unwrap_or(1.0), intercept.unwrap_or(0.0))?),
    };
    let unsigned = attributes.text("_Unsigned").map(|text| text.eq_ignore_ascii_case("true"));
    let scalar = unsigned.map_or(stored, |unsigned| with_sign(stored, !unsigned));
    let fills = FILL_VALUES.iter().filter_map(|name| attributes.numbers(name)).flat_map(|(numbers, _)| numbers);
    let mut fills: Vec<f64> = fills.collect();
    if attributes.numbers(FILL_VALUES[0]).is_none() {
        fills.extend(default_fill);
    }
    let missing = fills.into_iter().filter_map(|number| as_stored(number, scalar)).collect();
    Ok(Packed {
        scalar,
        rescale: rescale.unwrap_or_default(),
        missing: MissingData::new(missing, valid(scalar, attributes, rescale)),
    })
}

/// The number that NetCDF stores where nothing was written. Bytes have none.
#[cfg(feature = "hdf5")]
pub(super) fn netcdf_fill(scalar: ScalarType) -> Option<f64> {
    match scalar {
        ScalarType::Int16 => Some(-32_767.0),
        ScalarType::Uint16 => Some(65_535.0),
        ScalarType::Int32 => Some(-2_147_483_647.0),
        ScalarType::Uint32 => Some(4_294_967_295.0),
        ScalarType::Int64 => Some(-9_223_372_036_854_775_806.0),
        ScalarType::Uint64 => Some(18_446_744_073_709_551_614.0),
        ScalarType::Float32 | ScalarType::Float64 => Some(9.969_209_968_386_869e36),
        ScalarType::Uint8 | ScalarType::Int8 | ScalarType::Float16 => None,
    }
}

/// The range of stored numbers that are not missing. Of packed whole numbers, bounds that are floats are in units of values.
fn valid(scalar: ScalarType, attributes: &dyn Attributes, rescale: Option<Rescale>) -> (f64, f64) {
    let range = attributes.numbers("valid_range").filter(|(numbers, _)| numbers.len() == 2);
    let bound = |name: &str, n: usize| {
        let of_range = range.as_ref().map(|(numbers, is_float)| (numbers[n], *is_float));
        of_range.or_else(|| attributes.numbers(name).and_then(|(numbers, is_float)| Some((*numbers.first()?, is_float))))
    };
    let [lo, hi] = [bound("valid_min", 0), bound("valid_max", 1)];
    let is_whole = !matches!(scalar, ScalarType::Float16 | ScalarType::Float32 | ScalarType::Float64);
    let unpack = rescale.filter(|_| is_whole && [lo, hi].iter().flatten().any(|(_, is_float)| *is_float));
    let [lo, hi] = [lo, hi].map(|bound| bound.map(|(number, _)| number));
    let Some(rescale) = unpack else {
        let stored = |number: f64| as_stored(number, scalar).unwrap_or(number);
        return (lo.map_or(f64::NEG_INFINITY, stored), hi.map_or(f64::INFINITY, stored));
    };
    let ends = [lo, hi].map(|bound| bound.map(|value| rescale.stored(value)));
    let [lo, hi] = if rescale.slope() < 0.0 { [ends[1], ends[0]] } else { ends };
    (lo.map_or(f64::NEG_INFINITY, |lo| (lo - ROUNDING).ceil()), hi.map_or(f64::INFINITY, |hi| (hi + ROUNDING).floor()))
}

/// The integer type of the same size with or without a sign; floats as they are.
fn with_sign(scalar: ScalarType, signed: bool) -> ScalarType {
    use ScalarType::*;
    let pairs = [(Uint8, Int8), (Uint16, Int16), (Uint32, Int32), (Uint64, Int64)];
    let pair = pairs.into_iter().find(|(unsigned, with)| [*unsigned, *with].contains(&scalar));
    pair.map_or(scalar, |(unsigned, with)| if signed { with } else { unsigned })
}

/// A number as the type stores it; `None` if it cannot. Signs of whole numbers are those of the same bits.
fn as_stored(number: f64, scalar: ScalarType) -> Option<f64> {
    use ScalarType::*;
    let bits = 8 * scalar.bytes() as i32;
    let (lo, hi) = match scalar {
        Float16 => return Some(half::f16::from_f64(number).to_f64()),
        Float32 => return Some(f64::from(number as f32)),
        Float64 => return Some(number),
        Uint8 | Uint16 | Uint32 | Uint64 => (0.0, 2f64.powi(bits)),
        Int8 | Int16 | Int32 | Int64 => (-(2f64.powi(bits - 1)), 2f64.powi(bits - 1)),
    };
    let number = match number {
        n if n < 0.0 && lo == 0.0 => n + hi,
        n if n >= hi && lo < 0.0 => n - 2.0 * hi,
        n => n,
    };
    // 64-bit numbers near the upper end round to it.
    (number == number.floor() && number >= lo && number <= hi).then_some(number)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    struct Given(BTreeMap<&'static str, (Vec<f64>, bool)>, Option<&'static str>);

    impl Attributes for Given {
        fn numbers(&self, name: &str) -> Option<(Vec<f64>, bool)> {
            self.0.get(name).cloned()
        }

        fn text(&self, name: &str) -> Option<String> {
            self.1.filter(|_| name == "_Unsigned").map(Into::into)
        }
    }

    fn missing(
        scalar: ScalarType,
        given: &[(&'static str, &[f64], bool)],
        unsigned: Option<&'static str>,
        numbers: &[f64],
    ) -> Vec<bool> {
        let given = given.iter().map(|(name, numbers, is_float)| (*name, (numbers.to_vec(), *is_float))).collect();
        let packed = packed(scalar, &Given(given, unsigned), None).unwrap();
        numbers.iter().map(|number| packed.missing.has(*number)).collect()
    }

    #[test]
    fn fill_values_have_the_type_of_the_numbers() {
        let fill = f64::from(-9999.9f32);
        assert_eq!(missing(ScalarType::Float32, &[("missing_value", &[-9999.9], true)], None, &[fill, 0.0]), [true, false]);
        assert_eq!(missing(ScalarType::Int8, &[("_FillValue", &[-1.0], false)], Some("true"), &[255.0, 0.0]), [true, false]);
        assert_eq!(missing(ScalarType::Uint8, &[("_FillValue", &[255.0], false)], Some("false"), &[-1.0, 1.0]), [true, false]);
        // Neither 0 nor another number.
        assert_eq!(missing(ScalarType::Int16, &[("_FillValue", &[1e20, -0.5], true)], None, &[0.0, 32767.0]), [false, false]);
    }

    #[test]
    fn valid_ranges_are_of_packed_numbers_unless_they_are_floats() {
        let packing: (&str, &[f64], bool) = ("scale_factor", &[0.1], true);
        let numbers = [-1.0, 0.0, 661.0, 662.0];
        let outside = [true, false, false, true];
        assert_eq!(missing(ScalarType::Int16, &[packing, ("valid_range", &[0.0, 661.0], false)], None, &numbers), outside);
        let ends: [(&str, &[f64], bool); 2] = [("valid_min", &[0.0], true), ("valid_max", &[66.1], true)];
        assert_eq!(missing(ScalarType::Int16, &[packing, ends[0], ends[1]], None, &numbers), outside);
        // A negative slope exchanges the ends.
        let mirrored: (&str, &[f64], bool) = ("scale_factor", &[-0.1], true);
        let range: (&str, &[f64], bool) = ("valid_range", &[-66.1, 0.0], true);
        assert_eq!(missing(ScalarType::Int16, &[mirrored, range], None, &numbers), outside);
        let floats: [(&str, &[f64], bool); 1] = [("valid_max", &[0.1], true)];
        assert_eq!(missing(ScalarType::Float32, &floats, None, &[f64::from(0.1f32), 0.2]), [false, true]);
    }
}
