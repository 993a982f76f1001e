//! Volumes rendered by several processes: the pictures of a single process, and termination of all if one fails.

#[cfg(feature = "cli")]
mod command;
#[path = "../common/mod.rs"]
mod common;
mod devices;
mod launch;
mod light;
mod pictures;
mod volumes;

use launch::on_ranks;

/// Numbers of ranks: one, even, odd, and not a divisor of the layers.
const RANKS: [usize; 4] = [1, 2, 3, 5];

#[test]
#[ignore = "run by the other tests, under mpirun"]
fn as_a_rank() {
    launch::as_a_rank(|case, group| match case {
        "pictures" => pictures::are_those_of_one_process(group),
        "blends" => pictures::in_every_blend_mode(group),
        "accumulated" => pictures::accumulate(group),
        "measured" => pictures::are_measured(group),
        "again" => pictures::are_the_same_again(group),
        "changes" => pictures::follow_changes(group),
        "buffers" => pictures::in_several_buffers(group),
        "devices" => pictures::of_bricks_on_devices(group),
        "light" => light::is_that_of_one_process(group),
        "light again" => light::is_the_same_again(group),
        "light on devices" => light::of_bricks_on_devices(group),
        "reductions" => volumes::are_looked_at_together(group),
        "files" => volumes::are_read_in_parts(group),
        "refusals" => volumes::are_refused_on_all(group),
        other => panic!("no case {other}"),
    });
}

#[test]
fn pictures_are_those_of_one_process() {
    RANKS.iter().for_each(|&ranks| on_ranks(ranks, "pictures"));
}

#[test]
fn every_blend_mode() {
    [2, 3].iter().for_each(|&ranks| on_ranks(ranks, "blends"));
}

#[test]
fn accumulated_pictures() {
    RANKS.iter().for_each(|&ranks| on_ranks(ranks, "accumulated"));
}

#[test]
fn measured_pictures() {
    [1, 2].iter().for_each(|&ranks| on_ranks(ranks, "measured"));
}

#[test]
fn the_same_picture_again() {
    [3, 5].iter().for_each(|&ranks| on_ranks(ranks, "again"));
}

#[test]
fn changes_are_followed() {
    [1, 3].iter().for_each(|&ranks| on_ranks(ranks, "changes"));
}

#[test]
fn several_buffers() {
    [1, 2].iter().for_each(|&ranks| on_ranks(ranks, "buffers"));
}

#[test]
fn bricks_on_devices() {
    [1, 3].iter().for_each(|&ranks| on_ranks(ranks, "devices"));
}

#[test]
fn light_is_that_of_one_process() {
    RANKS.iter().for_each(|&ranks| on_ranks(ranks, "light"));
}

#[test]
fn the_same_light_again() {
    [1, 3].iter().for_each(|&ranks| on_ranks(ranks, "light again"));
}

#[test]
fn light_of_bricks_on_devices() {
    [1, 3].iter().for_each(|&ranks| on_ranks(ranks, "light on devices"));
}

#[test]
fn what_is_found_together() {
    RANKS.iter().for_each(|&ranks| on_ranks(ranks, "reductions"));
}

#[test]
fn files_are_read_in_parts() {
    [1, 3].iter().for_each(|&ranks| on_ranks(ranks, "files"));
}

#[test]
fn refusals_come_to_all() {
    [1, 3].iter().for_each(|&ranks| on_ranks(ranks, "refusals"));
}
