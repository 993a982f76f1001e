//! Parsers of option values.

use super::values::{Along, ChannelChoice, Component, LevelChoice, Opacities, Reach, Tent};
use crate::error::Error;
use crate::image::{Background, BitDepth};
use crate::layers::{Correction, Density, MAX_SAMPLES_PER_VOXEL};
use crate::renderer::ColorOpacity;
use crate::settings::{AmbientOcclusion, ClipPlane, CropBox, Evaluation, GradientOpacity, Light, Number, Sky, WHITE};
use crate::transfer::Value;
use crate::viewport::Viewport;
use crate::volume::{LabelChange, VoxelBox};
use glam::DVec3;
use std::time::Duration;

fn numbers(text: &str) -> Option<Vec<f64>> {
    text.split(',').map(|n| n.trim().parse().ok().filter(|n: &f64| n.is_finite())).collect()
}

/// Parses a finite number.
pub(super) fn finite(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|n: &f64| n.is_finite()).ok_or_else(|| format!("'{text}' is not a finite number"))
}

/// Parses a finite number above 0.
pub(super) fn positive(text: &str) -> Result<f64, String> {
    finite(text).ok().filter(|n| *n > 0.0).ok_or_else(|| format!("'{text}' is not a finite number above 0"))
}

/// Parses a number of the settings.
pub(super) fn number(number: Number) -> impl Fn(&str) -> Result<f64, String> + Clone {
    move |text| finite(text).ok().filter(|&n| number.contains(n)).ok_or_else(|| format!("'{text}' is not {}", number.expected()))
}

/// Parses a time above 0 in seconds.
pub(super) fn seconds(text: &str) -> Result<Duration, String> {
    let time = positive(text).ok().and_then(|n| Duration::try_from_secs_f64(n).ok()).filter(|time| !time.is_zero());
    time.ok_or_else(|| format!("'{text}' is not a time above 0 in seconds"))
}

/// Parses a number of bytes: `N`, `NK`, `NKiB` (1024) or `NKB` (1000), with K, M, G or T in any case.
pub(super) fn bytes(text: &str) -> Result<u64, String> {
    let refused =
        || format!("'{text}' is not a number of bytes above 0; use 900000, 512M or 512MiB (2^20 each), or 800MB (10^6)");
    let digits = text.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len());
    let (number, unit) = text.split_at(digits);
    let unit = unit.trim().to_ascii_lowercase();
    let power = |prefix: &str| ["", "k", "m", "g", "t"].iter().position(|p| *p == prefix).map(|n| n as i32);
    let scale = match (unit.strip_suffix("ib"), unit.strip_suffix('b')) {
        (Some(prefix), _) if !prefix.is_empty() => power(prefix).map(|n| 1024f64.powi(n)),
        (_, Some(prefix)) => power(prefix).map(|n| 1000f64.powi(n)),
        _ => power(&unit).map(|n| 1024f64.powi(n)),
    };
    let bytes = number.parse::<f64>().ok().zip(scale).map(|(number, scale)| number * scale);
    bytes.filter(|&n| n >= 1.0 && n < u64::MAX as f64).map(|n| n as u64).ok_or_else(refused)
}

/// Parses a resolution level: a number, or `auto`.
pub(super) fn level(text: &str) -> Result<LevelChoice, String> {
    match text {
        "auto" => Ok(LevelChoice::Auto),
        _ => text.parse().map(LevelChoice::Number).map_err(|_| format!("invalid level '{text}'; use a number from 0, or auto")),
    }
}

/// Parses a component: a number, a name, or `magnitude`.
pub(super) fn channel(text: &str) -> Result<ChannelChoice, String> {
    match text {
        "magnitude" => Ok(ChannelChoice::Magnitude),
        _ => component(text).map(ChannelChoice::One),
    }
}

/// Parses a component: a number, or a name.
pub(super) fn component(text: &str) -> Result<Component, String> {
    let text = text.trim();
    let is_number = text.parse::<f64>().is_ok();
    match text.parse() {
        Ok(number) => Ok(Component::Number(number)),
        Err(_) if text.is_empty() || is_number => {
            Err(format!("invalid channel '{text}'; use a number from 0, or the name of a channel"))
        }
        Err(_) => Ok(Component::Name(text.into())),
    }
}

/// Parses a place along an axis: a coordinate, or a percentage of the volume's extent.
pub(super) fn along(text: &str) -> Result<Along, String> {
    let refused = || format!("invalid place '{text}'; use a number, or a percentage from 0% to 100%");
    match text.strip_suffix('%') {
        Some(share) => {
            let share = finite(share.trim()).ok().filter(|share| (0.0..=100.0).contains(share));
            share.map(|share| Along::Share(share / 100.0)).ok_or_else(refused)
        }
        None => finite(text).map(Along::Coordinate).map_err(|_| refused()),
    }
}

/// Parses an angle between 0 and 180 degrees, exclusive.
pub(super) fn field_of_view(text: &str) -> Result<f64, String> {
    let fov = finite(text).ok().filter(|n| *n > 0.0 && *n < 180.0);
    fov.ok_or_else(|| format!("'{text}' is not between 0 and 180 degrees, exclusive"))
}

/// Parses `X,Y,Z`.
pub(super) fn vector(text: &str) -> Result<DVec3, String> {
    let vector = numbers(text).and_then(|n| <[f64; 3]>::try_from(n).ok());
    vector.map(DVec3::from_array).ok_or_else(|| format!("invalid vector '{text}'; use X,Y,Z"))
}

/// Parses `X,Y,Z` or `camera`, with an optional `:STRENGTH` (default 1), of a direction `:DEGREES` (default 0), and at last `:COLOR` (default
/// white).
pub(super) fn light(text: &str) -> Result<Light, String> {
    let refused = || {
        format!(
            "invalid light '{text}'; use X,Y,Z, X,Y,Z:STRENGTH, X,Y,Z:STRENGTH:DEGREES, camera or camera:STRENGTH, with a strength from 0 to \
             100 and an angular diameter from 0 to 45; a colour may follow: X,Y,Z:#ffc080"
        )
    };
    let mut parts: Vec<&str> = text.split(':').map(str::trim).collect();
    let place = parts.remove(0);
    let direction = if place == "camera" { None } else { Some(vector(place).map_err(|_| refused())?) };
    let color = match parts.last().and_then(|last| color(last).ok()) {
        Some(color) => {
            parts.pop();
            color
        }
        None => WHITE,
    };
    if parts.len() > 1 + usize::from(direction.is_some()) {
        return Err(refused());
    }
    let number = |n: usize, default| parts.get(n).map_or(Ok(default), |text| finite(text).map_err(|_| refused()));
    Ok(Light { direction, strength: number(0, 1.0)?, angle: number(1, 0.0)?, color, ..Light::AT_CAMERA })
}

/// Parses `X,Y,Z`, all above 0.
pub(super) fn spacing(text: &str) -> Result<DVec3, String> {
    let spacing = vector(text).ok().filter(|s| s.min_element() > 0.0);
    spacing.ok_or_else(|| format!("invalid spacing '{text}'; use X,Y,Z with numbers above 0"))
}

/// Parses `X0:X1,Y0:Y1,Z0:Z1` with X0 < X1 and so on. Omitted bounds are open.
pub(super) fn crop(text: &str) -> Result<CropBox, String> {
    let side = |side: &str, open: f64| if side.trim().is_empty() { Some(open) } else { finite(side.trim()).ok() };
    let extent = |extent: &str| {
        let (lo, hi) = extent.split_once(':')?;
        let (lo, hi) = (side(lo, f64::NEG_INFINITY)?, side(hi, f64::INFINITY)?);
        (lo < hi).then_some((lo, hi))
    };
    let extents: Option<Vec<_>> = text.split(',').map(extent).collect();
    let Some(&[x, y, z]) = extents.as_deref() else {
        return Err(format!("invalid box '{text}'; use X0:X1,Y0:Y1,Z0:Z1 in voxels, with X0 below X1 and so on"));
    };
    Ok(CropBox { lowest: DVec3::new(x.0, y.0, z.0), highest: DVec3::new(x.1, y.1, z.1) })
}

/// Parses `X0:X1,Y0:Y1,Z0:Z1` of whole numbers, the second behind the last voxel.
pub(super) fn region(text: &str) -> Result<VoxelBox, String> {
    let side = |side: &str, open: usize| if side.trim().is_empty() { Some(open) } else { side.trim().parse().ok() };
    let extent = |extent: &str| {
        let (lo, hi) = extent.split_once(':')?;
        let (lo, hi) = (side(lo, 0)?, side(hi, usize::MAX)?);
        (lo < hi).then(|| (lo, hi - lo))
    };
    let extents: Option<Vec<_>> = text.split(',').map(extent).collect();
    let Some(&[x, y, z]) = extents.as_deref() else {
        return Err(format!("invalid region '{text}'; use X0:X1,Y0:Y1,Z0:Z1 in voxels of level 0, with X0 below X1 and so on"));
    };
    Ok(VoxelBox { first: [x.0, y.0, z.0], dims: [x.1, y.1, z.1] })
}

/// Parses `X,Y,Z,NX,NY,NZ` with a non-zero normal.
pub(super) fn clip_plane(text: &str) -> Result<ClipPlane, String> {
    let plane = numbers(text).and_then(|n| <[f64; 6]>::try_from(n).ok());
    let plane = plane.map(|[x, y, z, nx, ny, nz]| ClipPlane { point: DVec3::new(x, y, z), normal: DVec3::new(nx, ny, nz) });
    let valid = plane.filter(|plane| plane.normal.try_normalize().is_some());
    valid.ok_or_else(|| format!("invalid plane '{text}'; use X,Y,Z,NX,NY,NZ: a point and a normal other than 0"))
}

/// Parses `alpha`, `luminance` or a colour.
pub(super) fn color_opacity(text: &str) -> Result<ColorOpacity, String> {
    match text {
        "alpha" => Ok(ColorOpacity::Alpha),
        "luminance" => Ok(ColorOpacity::Luminance),
        color => self::color(color)
            .map(ColorOpacity::FromBackground)
            .map_err(|problem| format!("expected alpha, luminance or a colour: {problem}")),
    }
}

/// Parses a colour.
pub(super) fn color(text: &str) -> Result<[f64; 3], String> {
    match text.parse()? {
        Background::Color(color) => Ok(color.map(f64::from)),
        Background::Transparent => Err("transparent is not a colour here: use white, grey, #rrggbb or R,G,B".into()),
    }
}

/// Parses `COLOR[,COLOR][:S]`: a sky of one colour, or of those above and below, with a strength. Colours are those of sRGB.
pub(super) fn sky(text: &str) -> Result<Sky, String> {
    let refused = || format!("invalid sky '{text}'; use a colour, or one above and one below, such as white,#404040:0.5");
    let (colors, strength) = match text.rsplit_once(':') {
        Some((colors, strength)) => (colors, strength.trim().parse().map_err(|_| refused())?),
        None => (text, 1.0),
    };
    let linear = |color: [f64; 3]| color.map(crate::color::linear);
    let pair = || {
        let (top, bottom) = colors.split_once(',')?;
        color(top).ok().zip(color(bottom).ok())
    };
    let (top, bottom) = color(colors).ok().map(|one| (one, one)).or_else(pair).ok_or_else(refused)?;
    Sky::STRENGTH.check(strength).map_err(|problem| problem.to_string())?;
    Ok(Sky { top: linear(top), bottom: linear(bottom), strength, ..Sky::default() })
}

/// Parses a data value: a number or a percentile.
pub(super) fn value(text: &str) -> Result<Value, String> {
    text.parse().map_err(|_| format!("invalid value '{}'; use a finite number, or a percentile from p0 to p100", text.trim()))
}

/// Whether `a` can be below `b`. The order of a number and a percentile depends on the volume.
fn may_be_below(a: Value, b: Value) -> bool {
    match (a, b) {
        (Value::Number(a), Value::Number(b)) | (Value::Percentile(a), Value::Percentile(b)) => a < b,
        _ => true,
    }
}

/// Parses `LO,HI`.
pub(super) fn range(text: &str) -> Result<(Value, Value), String> {
    let refused = || format!("invalid range '{text}'; use LO,HI with LO below HI, each a number or a percentile such as p99.5");
    let (lo, hi) = text.split_once(',').ok_or_else(refused)?;
    let range = value(lo).ok().zip(value(hi).ok());
    range.filter(|&(lo, hi)| may_be_below(lo, hi)).ok_or_else(refused)
}

/// Parses `V:A,V:A,…` with opacities from 0 to 1 and ascending values. A value may occur twice for a step.
pub(super) fn opacities(text: &str) -> Result<Opacities, String> {
    let point = |point: &str| {
        let (at, opacity) = point.split_once(':')?;
        Some((value(at).ok()?, finite(opacity.trim()).ok().filter(|a| (0.0..=1.0).contains(a))?))
    };
    let points: Option<Vec<_>> = text.split(',').map(point).collect();
    let expected = "use V:A,V:A,… with values (numbers, or percentiles such as p99.5) and opacities from 0 to 1";
    let points = points.ok_or_else(|| format!("invalid opacities '{text}'; {expected}"))?;
    match points.windows(2).find(|pair| pair[0].0 != pair[1].0 && !may_be_below(pair[0].0, pair[1].0)) {
        Some(_) => Err(format!("invalid opacities '{text}'; sort them by value")),
        None => Ok(Opacities(points)),
    }
}

/// Parses `G:F,G:F,…`: gradient magnitudes and opacity factors.
pub(super) fn gradient_opacity(text: &str) -> Result<GradientOpacity, String> {
    let point = |point: &str| {
        let (length, factor) = point.split_once(':')?;
        Some((finite(length.trim()).ok()?, finite(factor.trim()).ok()?))
    };
    let points: Option<Vec<_>> = text.split(',').map(point).collect();
    let valid = points.and_then(|points| GradientOpacity::new(&points).ok());
    valid.ok_or_else(|| {
        format!("invalid gradient opacity '{text}'; use up to 8 pairs G:F,G:F,… sorted by G, with G at least 0 and F from 0 to 1")
    })
}

/// Parses `LEVEL,WIDTH`.
pub(super) fn window(text: &str) -> Result<(Value, f64), String> {
    let window = text.split_once(',').and_then(|(level, width)| Some((value(level).ok()?, positive(width.trim()).ok()?)));
    window.ok_or_else(|| {
        format!("invalid window '{text}'; use LEVEL,WIDTH: a value (a number, or a percentile such as p50) and a number above 0")
    })
}

/// Parses a change of labels: `IDS[:COLOR][:OPACITY][:show|hide|only|highlight]`.
pub(super) fn label(text: &str) -> Result<LabelChange, String> {
    text.parse().map_err(|e: Error| match e {
        Error::Settings { problem, .. } => problem,
        e => e.to_string(),
    })
}

/// Default opacity at the peak of a tent.
const TENT_OPACITY: f64 = 0.5;

/// Parses `V,WIDTH` or `V,WIDTH,OPACITY`.
pub(super) fn tent(text: &str) -> Result<Tent, String> {
    let mut parts = text.splitn(3, ',');
    let mut tent = || {
        let (at, width) = (value(parts.next()?).ok()?, positive(parts.next()?.trim()).ok()?);
        let opacity = parts.next().map_or(Some(TENT_OPACITY), |a| finite(a.trim()).ok().filter(|a| (0.0..=1.0).contains(a)))?;
        Some(Tent { value: at, width, opacity })
    };
    tent().ok_or_else(|| {
        format!(
            "invalid tent '{text}'; use V,WIDTH or V,WIDTH,OPACITY: a value (a number, or a percentile such as p95), a width above 0 \
             and an opacity from 0 to 1"
        )
    })
}

/// Parses `XxYxZ`, each at least 1.
pub(super) fn dims(text: &str) -> Result<[usize; 3], String> {
    let sizes: Option<Vec<usize>> = text.split('x').map(|n| n.parse().ok().filter(|&n| n > 0)).collect();
    let dims = sizes.and_then(|s| s.try_into().ok());
    dims.ok_or_else(|| format!("invalid dimensions '{text}'; use XxYxZ with whole numbers above 0"))
}

/// Parses `WxH` in pixels, or the side of a square.
pub(super) fn viewport(text: &str) -> Result<Viewport, String> {
    let invalid = || format!("invalid size '{text}'; use WIDTHxHEIGHT or the side of a square, e.g. 800x600 or 800");
    let (w, h) = text.split_once(['x', 'X', '×']).unwrap_or((text, text));
    let side = |n: &str| n.parse::<u32>().map_err(|_| invalid());
    Viewport::new(side(w)?, side(h)?).map_err(|e| e.to_string())
}

/// Parses a length above 0, or `inf`.
pub(super) fn reach(text: &str) -> Result<Reach, String> {
    if text == "inf" { Ok(Reach(None)) } else { number(AmbientOcclusion::REACH)(text).map(|length| Reach(Some(length))) }
}

/// Parses `on` or `off`.
pub(super) fn switch(text: &str) -> Result<bool, String> {
    match text {
        "on" => Ok(true),
        "off" => Ok(false),
        _ => Err("use on or off".into()),
    }
}

/// Parses `auto`, `direct` or a number of samples per voxel.
pub(super) fn lattice(text: &str) -> Result<Evaluation, String> {
    match (text, text.parse::<u32>()) {
        ("auto", _) => Ok(Evaluation::Lattice(Density::Relaxed)),
        ("direct", _) => Ok(Evaluation::Direct),
        (_, Ok(m)) if (1..=MAX_SAMPLES_PER_VOXEL).contains(&m) => Ok(Evaluation::Lattice(Density::Fixed(m))),
        _ => Err(format!("use auto, direct or 1 to {MAX_SAMPLES_PER_VOXEL} samples per voxel")),
    }
}

/// Parses a number of sub-layers from 1 to 16.
pub(super) fn sub_layers(text: &str) -> Result<u32, String> {
    let count = text.parse().ok().filter(|n| (1..=Correction::MAX_SUB_LAYERS).contains(n));
    count.ok_or_else(|| format!("'{text}' is not a number of sub-layers from 1 to {}", Correction::MAX_SUB_LAYERS))
}

/// Parses the bits per channel of a picture: 8 or 16.
pub(super) fn bits(text: &str) -> Result<BitDepth, String> {
    match text {
        "8" => Ok(BitDepth::Eight),
        "16" => Ok(BitDepth::Sixteen),
        _ => Err(format!("'{text}' is not a number of bits per channel: use 8 or 16")),
    }
}

/// Parses a number of samples along the side of a pixel, from 1 to 16.
pub(super) fn samples(text: &str) -> Result<u32, String> {
    let count = text.parse().ok().filter(|n| (1..=16).contains(n));
    count.ok_or_else(|| format!("'{text}' is not a number of samples along a pixel's side, from 1 to 16"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bad_values_are_refused() {
        for bad in ["", "NaN", "inf", "1e999", "x"] {
            assert!(finite(bad).is_err() && positive(bad).is_err() && vector(bad).is_err(), "{bad}");
        }
        assert!(positive("0").is_err() && positive("-1").is_err());
        assert!(field_of_view("0").is_err() && field_of_view("180").is_err() && field_of_view("30").is_ok());
        assert!(spacing("1,0,1").is_err() && spacing("1,1").is_err() && spacing("1,2,3").is_ok());
        assert!(range("2,1").is_err() && range("1,1").is_err() && range("-1,1").is_ok());
        assert!(range("p9,p5").is_err() && range("p5").is_err() && range("p5,7").is_ok() && range("p101,200").is_err());
        assert!(window("5").is_err() && window("5,0").is_err() && window("p50,-1").is_err() && window("p50,20").is_ok());
        for bad in ["", "5", "5:2", "5:-0.1", "5:NaN", "NaN:0.5", "5:0,1:1", "p9:0,p5:1", "5:0,", "5:0;6:1"] {
            assert!(opacities(bad).is_err(), "{bad}");
        }
        for (good, points) in [("5:1", 1), ("-5:0, p50:0.5 ,7:1", 3), ("5:0,5:1", 2), ("p5:0,p5:1", 2)] {
            assert_eq!(opacities(good).map(|given| given.0.len()), Ok(points), "{good}");
        }
        for bad in ["", "5", "5,0", "5,-1", "5,1,2", "5,1,0.5,7", "NaN,1", "5,1,"] {
            assert!(tent(bad).is_err(), "{bad}");
        }
        assert!(tent("p99,4").is_ok_and(|t| t.opacity == TENT_OPACITY) && tent("-3,4,0").is_ok_and(|t| t.opacity == 0.0));
        assert!(dims("0x1x1").is_err() && dims("1x1").is_err() && dims("-1x1x1").is_err() && dims("3x4x5").is_ok());
        assert!(viewport("0x5").is_err() && viewport("99999x5").is_err() && viewport("5x").is_err());
        assert_eq!(viewport("5"), viewport("5x5"));
        assert!(lattice("0").is_err() && lattice("17").is_err() && lattice("16").is_ok());
        for bad in ["", "0", "-1", "K", "1X", "1 iB", "1e3", "1..2", "0.5", "99999999T", "1Kb b"] {
            assert!(bytes(bad).is_err(), "{bad}");
        }
        for (text, expected) in [
            ("900000", 900_000),
            ("512M", 512 << 20),
            ("512MiB", 512 << 20),
            ("512 mib", 512 << 20),
            ("1.5G", 3 << 29),
            ("800MB", 800_000_000),
            ("7kB", 7000),
            ("3B", 3),
            ("2t", 2 << 40),
        ] {
            assert_eq!(bytes(text), Ok(expected), "{text}");
        }
        for bad in ["", ":", "1,0", "1,0,0:", "1,0,0:x", "1,0,0:1:2:3", "camera:1:2", ":2", "sun", "1,0,0:inf"] {
            assert!(light(bad).is_err(), "{bad}");
        }
        assert_eq!(light("-1,0.5,2:0.25"), Ok(Light { strength: 0.25, ..Light::towards(DVec3::new(-1.0, 0.5, 2.0)) }));
        assert_eq!(light("0,0,1:0.5:10"), Ok(Light { strength: 0.5, angle: 10.0, ..Light::towards(DVec3::Z) }));
        let red = Light { color: [1.0, 0.0, 0.0], ..Light::towards(DVec3::Z) };
        for text in ["0,0,1:#ff0000", "0,0,1:1,0,0", "0,0,1:1:0:#ff0000"] {
            assert_eq!(light(text), Ok(red), "{text}");
        }
        let orange = Light { strength: 0.5, color: [1.0, 0.5, 0.0], ..Light::AT_CAMERA };
        assert_eq!(light("camera:0.5:1,0.5,0"), Ok(orange));
        assert_eq!((light("camera"), light("0,0,1")), (Ok(Light::AT_CAMERA), Ok(Light::towards(DVec3::Z))));
        for bad in ["", "%", "-1%", "101%", "x", "inf"] {
            assert!(along(bad).is_err(), "{bad}");
        }
        assert_eq!((along("-3.5"), along("25 %")), (Ok(Along::Coordinate(-3.5)), Ok(Along::Share(0.25))));
        assert!(label("3,7-9:#ff0000:0.4").is_ok() && label("3").unwrap_err().starts_with("invalid change '3'"));
        assert!(samples("0").is_err() && samples("17").is_err() && samples("x").is_err() && samples("16") == Ok(16));
        assert!(sub_layers("0").is_err() && sub_layers("17").is_err());
    }
}
