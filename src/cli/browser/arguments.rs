//! A look and a camera as options of the command. Settings are made of the same options, so the page draws what the command draws.

use super::first_fields::FirstFields;
use super::given::{GivenOption, GivenOptions};
use crate::cli::blending::BlendOptions;
use crate::cli::options::{QualityOptions, quoted};
use crate::error::Error;
use crate::settings::{self, Argument, Blend, Quality, Setting, Settings, WHITE};
use crate::transfer::Value;
use crate::viewer::{FilmWanted, Look, PageProjection, PageStudio, Wanted};
use crate::viewport::Viewport;
use clap::Parser;
use std::iter::once;

/// The options that settings are made of.
#[derive(Parser)]
#[command(name = "look")]
struct LookOptions {
    #[command(flatten)]
    quality: QualityOptions,
    #[command(flatten)]
    blend: BlendOptions,
}

/// The options of a look. `is_layered`: whether the algorithm has qualities.
pub(super) fn of_look(look: &Look, quality: Option<Quality>, is_layered: bool) -> Vec<String> {
    let mut words = Vec::new();
    let mut add = |option: &str, value: String| words.extend([option.to_owned(), value]);
    if let Some(quality) = quality.filter(|_| is_layered) {
        add("--quality", quality.name().into());
    }
    if let Some(kernel) = look.kernel.filter(|_| is_layered) {
        add("--kernel", kernel.name().into());
    }
    if let Some(gradient) = &look.gradient {
        add("--gradient", gradient.clone());
    }
    if look.blend != Blend::Composite {
        add("--blend", look.blend.name().into());
    }
    if let Blend::Iso(_) = look.blend {
        add("--iso", look.iso.to_string());
    }
    let studio = look.drawn_studio();
    match studio {
        Some(PageStudio { sky_up, scattering, exposure }) => {
            add("--look", settings::Look::Studio.name().into());
            add("--sky-up", list(&sky_up));
            add("--scattering", scattering.to_string());
            add("--exposure", exposure.to_string());
        }
        None if !look.shading => add("--shading", "off".into()),
        None => {}
    }
    if look.shading || studio.is_some() {
        for light in &look.lights {
            let strength = light.strength;
            let color = if light.color == WHITE { String::new() } else { format!(":{}", list(&light.color)) };
            add(
                "--light",
                match light.direction {
                    Some(direction) => format!("{}:{strength}:{}{color}", list(&direction), light.angle),
                    None => format!("camera:{strength}{color}"),
                },
            );
        }
        if look.is_lit_from_camera() {
            add("--light-space", "camera".into());
        }
    }
    if casts_shadows(look) {
        add("--shadows", "on".into());
        if look.shadow_strength < 1.0 {
            add("--shadow-strength", look.shadow_strength.to_string());
        }
    }
    if has_occlusion(look) {
        add("--ambient-occlusion", "on".into());
    }
    if let Some([lowest, highest]) = look.crop {
        let side = |i: usize| format!("{}:{}", lowest[i], highest[i]);
        add("--crop", [side(0), side(1), side(2)].join(","));
    }
    for clip in &look.clips {
        add("--clip", list(clip));
    }
    for (setting, argument) in Setting::plain().filter_map(|setting| Some((setting, look.plain.get(setting.name)?))) {
        let value = match argument {
            Argument::Switch(on) => if *on { "on" } else { "off" }.into(),
            Argument::Name(name) => name.clone(),
            number => number.to_string(),
        };
        words.extend([format!("--{}", setting.option.expect("plain settings have options")), value]);
    }
    words
}

/// The settings of a look, with the options that were given.
pub(super) fn settings(given: &GivenOptions, look: &Look, quality: Option<Quality>, is_layered: bool) -> Result<Settings, Error> {
    let words = once("look".to_owned()).chain(kept(&given.drawing, look)).chain(of_look(look, quality, is_layered));
    let refused = |e: clap::Error| {
        let problem = e.to_string().lines().next().unwrap_or_default().trim_start_matches("error: ").to_owned();
        Error::Settings { field: "page", problem }
    };
    let options = LookOptions::try_parse_from(words).map_err(refused)?;
    options.blend.check()?;
    let settings = options.quality.settings(Some(look.background()?))?;
    // The page's values are numbers.
    Ok(options.blend.apply(settings, |value| match value {
        Value::Number(number) => number,
        Value::Percentile(_) => f64::NAN,
    }))
}

/// The volume of a picture as commands name it: a step of a sequence, or the volume itself.
pub(super) struct Source {
    pub volume: String,
    /// Frame of a sequence.
    pub frame: Option<usize>,
}

/// The command that renders a picture.
pub(super) fn render(given: &GivenOptions, fields: &FirstFields, source: Source, wanted: &Wanted, is_layered: bool) -> String {
    let &Wanted { look, camera, size, samples, format, transfer, others, length_units, .. } = wanted;
    let mut words = vec!["layersplat".to_owned(), "render".into(), source.volume];
    words.extend(given.reading.iter().flat_map(|option| option.words.clone()));
    words.extend(source.frame.into_iter().flat_map(|frame| ["--frame".to_owned(), frame.to_string()]));
    if fields.have_transfer() {
        words.extend(["--transfer".into(), transfer.into()]);
    }
    words.extend(fields.words(look, others));
    let mut add = |option: &str, value: String| words.extend([option.to_owned(), value]);
    add("--azimuth", camera.azimuth.to_string());
    add("--elevation", camera.elevation.to_string());
    add("--roll", camera.roll.to_string());
    add("--center", list(&camera.center));
    add("--fit", "volume".into());
    match camera.projection {
        PageProjection::ParallelScale(scale) => add("--parallel-scale", scale.to_string()),
        PageProjection::Perspective([field_of_view, distance]) => {
            add("--perspective", field_of_view.to_string());
            add("--distance", distance.to_string());
        }
    }
    let drawn = Drawn { look, size, samples, length_units, output: format.file_name() };
    words.extend(drawn.words(given, is_layered));
    line(&words)
}

/// The command that renders a film along key cameras.
pub(super) fn rotate(given: &GivenOptions, fields: &FirstFields, wanted: &FilmWanted, is_layered: bool) -> String {
    let &FilmWanted { look, size, samples, rate, output, keys, transfer, others, length_units } = wanted;
    let mut words = vec!["layersplat".to_owned(), "rotate".into(), given.volume.clone()];
    words.extend(given.more.clone());
    words.extend(given.reading.iter().flat_map(|option| option.words.clone()));
    if fields.have_transfer() {
        words.extend(["--transfer".into(), transfer.into()]);
    }
    words.extend(fields.words(look, others));
    let mut add = |option: &str, value: String| words.extend([option.to_owned(), value]);
    add("--keys", keys.into());
    add("--fit", "volume".into());
    add("--rate", rate.to_string());
    words.extend(Drawn { look, size, samples, length_units, output }.words(given, is_layered));
    line(&words)
}

/// What commands of pictures and of films have in common.
struct Drawn<'a> {
    look: &'a Look,
    size: Viewport,
    samples: u32,
    length_units: Option<&'a str>,
    output: &'a str,
}

impl Drawn<'_> {
    fn words(&self, given: &GivenOptions, is_layered: bool) -> Vec<String> {
        let &Self { look, size, samples, length_units, output } = self;
        let mut words = vec!["--size".to_owned(), format!("{}x{}", size.width, size.height)];
        words.extend(["--background".into(), look.background.clone()]);
        if samples > 1 {
            words.extend(["--samples".into(), samples.to_string()]);
        }
        words.extend(kept(&given.drawing, look));
        words.extend(of_look(look, look.quality, is_layered));
        words.extend(annotations(look, length_units));
        words.extend(["-o".into(), output.into()]);
        words
    }
}

/// A command for a shell.
fn line(words: &[String]) -> String {
    words.iter().map(|word| quoted(word)).collect::<Vec<_>>().join(" ")
}

/// The options of annotations, which lie over the picture as on the page.
fn annotations(look: &Look, length_units: Option<&str>) -> Vec<String> {
    let drawn = [(look.legend, "--legend"), (look.bounding_box, "--box"), (look.axes, "--axes")];
    let mut words: Vec<String> = drawn.into_iter().filter(|(is_drawn, _)| *is_drawn).map(|(_, option)| option.into()).collect();
    if look.legend || look.axes {
        words.extend(["--legend-place".into(), "over".into()]);
    }
    if let Some(units) = length_units.filter(|_| look.legend) {
        words.extend(["--length-units".into(), units.into()]);
    }
    words
}

/// Given options that go with a look: those of shadows and of the studio only where they are drawn.
fn kept<'a>(given: &'a [GivenOption], look: &'a Look) -> impl Iterator<Item = String> + 'a {
    let goes = |option: &&GivenOption| match option.id.as_str() {
        "ambient_color" => look.shading && look.drawn_studio().is_none(),
        "sky" | "tone" => look.drawn_studio().is_some(),
        "shadow_forgiveness" => casts_shadows(look),
        "ao_reach" => has_occlusion(look),
        "light_grid" => casts_shadows(look) || has_occlusion(look) || look.drawn_studio().is_some(),
        _ => true,
    };
    given.iter().filter(goes).flat_map(|option| option.words.clone())
}

/// Whether samples are lit by the plain look.
fn is_lit(look: &Look) -> bool {
    look.shading && look.drawn_studio().is_none() && !look.blend.gathers_values()
}

fn casts_shadows(look: &Look) -> bool {
    look.shadows && is_lit(look)
}

fn has_occlusion(look: &Look) -> bool {
    look.ambient_occlusion && is_lit(look)
}

fn list(numbers: &[f64]) -> String {
    numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Background;
    use crate::layers::Kernel;
    use crate::settings::{LightSpace, Lights, Shadows};
    use crate::viewer::PageLight;

    fn look() -> Look {
        Look::of(&Settings::default(), Background::BLACK, 90.0, [8; 3])
    }

    fn made(look: &Look, quality: Option<Quality>) -> Settings {
        settings(&GivenOptions::default(), look, quality, true).unwrap()
    }

    #[test]
    fn the_first_look_has_the_settings_of_the_preset() {
        assert_eq!(made(&look(), None), Settings::default());
        for quality in [Quality::Draft, Quality::Standard, Quality::High, Quality::Paper] {
            assert_eq!(made(&look(), Some(quality)), quality.settings());
        }
    }

    /// Settings become a look, and the look becomes the same settings.
    #[test]
    fn looks_and_settings_are_the_same() {
        let light =
            PageLight { direction: Some([0.1, -0.30000000000000004, 1e-7]), strength: 0.7, angle: 3.0, color: [1.0, 0.5, 0.25] };
        let headlight = PageLight { direction: None, strength: 0.25, angle: 0.0, color: WHITE };
        let studio = PageStudio { sky_up: [0.1, 1.0 / 3.0, -1e-7], scattering: 0.3, exposure: -1.0 / 3.0 };
        let looks = [
            Look { blend: Blend::Iso(0.0), iso: -12.3456789012345, ..look() },
            Look { blend: Blend::Maximum, ..look() },
            Look { shading: false, ..look() },
            Look { lights: vec![light, headlight], ..look() },
            Look { lights: vec![light], lights_follow: true, shadows: true, shadow_strength: 0.4, ..look() },
            Look { ambient_occlusion: true, ..look() },
            Look { lights: vec![light, headlight], studio: Some(studio), ..look() },
            Look { lights: vec![headlight], lights_follow: true, studio: Some(studio), ..look() },
            Look { gradient: Some("gaussian:0.7".into()), ..look() },
            Look {
                plain: [
                    ("gamma".to_owned(), Argument::Number(1.0 / 3.0)),
                    ("unit_distance".to_owned(), Argument::Number(0.7)),
                    ("extinction".to_owned(), Argument::Name("linear".into())),
                    ("early_termination".to_owned(), Argument::Switch(false)),
                ]
                .into(),
                ..look()
            },
            Look {
                crop: Some([[0.0, 1.5, 2.0], [3.0, 4.0, 1.0 / 3.0 + 5.0]]),
                clips: vec![[1.0, 2.0, 3.0, -1.0, 0.0, 0.5]; 2],
                ..look()
            },
        ];
        for look in looks {
            let settings = made(&look, None);
            let again = Look::of(&settings, Background::BLACK, look.iso, [8; 3]);
            let is_headlight = look.studio.is_none() && look.lights.iter().all(|light| light.direction.is_none());
            let follows = look.lights_follow || is_headlight;
            assert_eq!(again, Look { lights_follow: follows, ..look.clone() });
        }
        let beside = made(&Look { shadows: true, ..look() }, None);
        assert_eq!((beside.shading.unwrap().lights, beside.shadows), (Lights::BESIDE_CAMERA, Some(Shadows::default())));
        let placed = made(&Look { lights: vec![light], lights_follow: true, ..look() }, None).shading.unwrap().lights;
        assert_eq!(placed.as_slice()[0].space, LightSpace::Camera);
    }

    /// What does not go with a look is left out, not refused.
    #[test]
    fn shadows_stay_where_they_are_seen() {
        let shadowed = Look { shadows: true, ambient_occlusion: true, ..look() };
        let option = |id: &str, words: &[&str]| GivenOption { id: id.into(), words: words.iter().map(|&w| w.into()).collect() };
        let drawing = vec![
            option("shadow_forgiveness", &["--shadow-forgiveness", "2"]),
            option("ao_reach", &["--ao-reach", "5"]),
            option("light_grid", &["--light-grid", "half"]),
        ];
        let given = GivenOptions { drawing, ..GivenOptions::default() };
        let full = settings(&given, &shadowed, None, true).unwrap();
        assert!(full.shadows.is_some_and(|s| s.forgiveness == 2.0) && full.ambient_occlusion.is_some());
        for without in [Look { blend: Blend::Average, ..shadowed.clone() }, Look { shading: false, ..shadowed.clone() }, look()] {
            let settings = settings(&given, &without, None, true).unwrap();
            assert!(settings.shadows.is_none() && settings.ambient_occlusion.is_none());
        }
    }

    #[test]
    fn conflicts_are_sentences() {
        let wrong = Look { kernel: Some(Kernel::Linear), quality: Some(Quality::Paper), ..look() };
        let message = settings(&GivenOptions::default(), &wrong, Some(Quality::Paper), true).unwrap_err().to_string();
        assert!(message.contains("cubic"), "{message}");
        // Other algorithms have no quality.
        let drawing = vec![GivenOption { id: "algorithm".into(), words: vec!["--algorithm".into(), "raycast".into()] }];
        let given = GivenOptions { drawing, ..GivenOptions::default() };
        assert!(settings(&given, &look(), Some(Quality::High), false).unwrap().layered().is_none());
        assert_eq!(made(&Look { blend: Blend::Iso(0.0), iso: 4.5, ..look() }, None).blend, Blend::Iso(4.5));
    }

    #[test]
    fn words_are_quoted_for_shells() {
        assert_eq!(["a.raw", "it's", "#ffffff", "", "a b"].map(quoted), ["a.raw", r"'it'\''s'", "'#ffffff'", "''", "'a b'"]);
    }
}
