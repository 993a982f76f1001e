//! Command line options for the library's field names.

use crate::error::Error;

/// Field names as in [`Error::fields`], and the options that set them; sorted by field.
const OPTIONS: [(&str, &str); 72] = [
    ("algorithm", "--algorithm"),
    ("ambient_color", "--ambient-color COLOR"),
    ("ambient_occlusion", "--ambient-occlusion on|off"),
    ("ao_reach", "--ao-reach inf|LENGTH"),
    ("array", "--array NAME"),
    ("at", "--at N|N%"),
    ("axis", "--axis x|y|z|axial|coronal|sagittal"),
    ("background", "--background"),
    ("bits", "--bits N"),
    ("blend", "--blend composite|maximum|minimum|average|iso"),
    ("cameras", "--cameras FILE"),
    ("channel", "--channel N|magnitude"),
    ("channels", "--channels N,N|all, --with FILE, --scene FILE"),
    ("classification", "--classification post|preintegrated"),
    ("clipping", "--clip X,Y,Z,NX,NY,NZ"),
    ("color_opacity", "--color-opacity alpha|luminance|COLOR"),
    ("colors", "--colors direct|direction"),
    ("correction", "--correction none|constant|sublayers"),
    ("density", "--lattice auto|direct|N"),
    ("depth_cue", "--depth-cue STRENGTH"),
    ("device", "--device"),
    ("device_unchecked", "--device-unchecked"),
    ("dims", "--dims XxYxZ"),
    ("dither", "--dither"),
    ("dpi", "--dpi N"),
    ("endian", "--endian"),
    ("evaluation", "--lattice direct|auto|N"),
    ("field", "--field N,KEY=VALUE"),
    ("field_of_view", "--perspective FOV"),
    ("font_size", "--font-size POINTS"),
    ("footprints", "--footprints exact|set"),
    ("frame", "--frame N"),
    ("from", "--from front|right|back|left|above|below"),
    ("gradient", "--gradient central|sobel|gaussian:SIGMA|own"),
    ("gradient_opacity", "--gradient-opacity G:F,G:F"),
    ("header_bytes", "--header-bytes N"),
    ("kernel", "--kernel cubic|linear|catmull-rom|bspline|gaussian"),
    ("label", "--label IDS:CHANGES"),
    ("label_colors", "--label-colors FILE"),
    ("label_surfaces", "--label-surfaces smooth|voxels"),
    ("labels", "--labels=TABLE"),
    ("layer_axis", "--layer-axis auto|x|y|z"),
    ("level", "--level N|auto"),
    ("light", "--light X,Y,Z[:S[:DEGREES]][:COLOR]"),
    ("light_grid", "--light-grid full|half|quarter"),
    ("longest", "--time-limit SECONDS"),
    ("memory", "--memory BYTES"),
    ("output", "--output"),
    ("palette", "--palette"),
    ("plane", "--plane X,Y,Z,NX,NY,NZ"),
    ("preset", "--preset"),
    ("quality", "--quality"),
    ("samples", "--samples N"),
    ("samples_per_layer", "--sublayers N"),
    ("scale", "--parallel-scale"),
    ("series", "--series NAME"),
    ("shadow_forgiveness", "--shadow-forgiveness F"),
    ("shadow_strength", "--shadow-strength SHARE"),
    ("shadows", "--shadows on|off"),
    ("sheet_distance", "--sheet-distance D"),
    ("spacing", "--spacing X,Y,Z"),
    ("step", "--step D"),
    ("tent", "--tent V,WIDTH"),
    ("thickness", "--thickness T"),
    ("time", "--time"),
    ("transfer function", "--transfer"),
    ("transfer range", "--transfer-range LO,HI"),
    ("unit_distance", "--unit-distance D"),
    ("values", "--values"),
    ("viewport", "--size WxH"),
    ("voxel_type", "--type"),
    ("window", "--window LEVEL,WIDTH"),
];

/// The error's message, followed by the options that set the fields at fault.
pub(super) fn with_options(error: &Error) -> String {
    let find_option = |field: &&str| OPTIONS.iter().find(|(name, _)| name == field).map(|(_, option)| *option);
    let options: Vec<&str> = error.fields().iter().filter_map(find_option).collect();
    if options.is_empty() { error.to_string() } else { format!("{error} ({})", options.join(", ")) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn options_exist() {
        let command = super::super::Cli::command();
        let commands = ["render", "slice", "rotate", "info"].map(|name| command.find_subcommand(name).unwrap());
        for (field, option) in OPTIONS {
            let name = option.split([' ', '=']).next().unwrap().strip_prefix("--").unwrap();
            let mut arguments = commands.iter().flat_map(|command| command.get_arguments());
            let found = arguments.find(|argument| argument.get_long() == Some(name));
            let found = found.unwrap_or_else(|| panic!("{field}: no option {option}"));
            let values: Vec<String> = found.get_possible_values().iter().map(|value| value.get_name().into()).collect();
            if let Some((_, named)) = option.split_once(' ').filter(|_| !values.is_empty()) {
                assert_eq!(named.split('|').collect::<Vec<_>>(), values, "{option}");
            }
        }
        assert!(OPTIONS.is_sorted());
    }

    #[test]
    fn messages_name_field_and_option() {
        let step = Error::OutOfRange { name: "step", value: "0".into(), expected: "more" };
        assert_eq!(with_options(&step), "step is 0: expected more (--step D)");
        let memory = Error::DeviceMemory { what: "it".into(), device: "d".into(), needed: 2, available: 1 };
        assert!(with_options(&memory).ends_with("(--device)"));
        let other = Error::Camera { problem: "no view" };
        assert_eq!(with_options(&other), other.to_string());
    }
}
