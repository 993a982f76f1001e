//! Datasets of a file.

use super::elsewhere::{self, Others};
use super::numbers::{is_complex, scalar};
use crate::error::Error;
use crate::volume::format::COMPLEX;
use hdf5_reader::group::Group;
use hdf5_reader::{Dataset, Datatype, Hdf5File};
use std::collections::BTreeSet;
use std::path::Path;

/// Limit of datasets and groups visited.
const MOST: usize = 10_000;
/// Groups of MATLAB's own data.
const INTERNAL: [&str; 2] = ["#refs#", "#subsystem#"];

/// What is wrong with a file that the library cannot read.
pub(super) fn damaged(path: &Path, e: &hdf5_reader::error::Error) -> Error {
    if elsewhere::is_virtual(e) {
        return Error::volume(path, elsewhere::virtual_problem(path));
    }
    Error::volume(path, format!("it cannot be read: {e}"))
}

/// The dataset `name`.
pub(super) fn named(path: &Path, file: &Hdf5File, name: &str, others: &Others) -> Result<Dataset, Error> {
    let found = file.dataset(name);
    found.map_err(|e| match (volumes(path, file, |dtype| scalar(dtype).is_some()), others.problem()) {
        _ if elsewhere::is_virtual(&e) => damaged(path, &e),
        (Ok(names), problem) if !names.is_empty() || problem.is_none() => {
            let missing = problem.map_or(String::new(), |problem| format!("; {problem}"));
            let problem = format!("'{name}' is not in {}, whose arrays are {}{missing}", path.display(), names.join(", "));
            Error::Settings { field: "array", problem }
        }
        (Ok(_), problem) => Error::volume(path, problem.unwrap_or_default()),
        (Err(e), _) => e,
    })
}

/// The dataset with the most axes, if it is unique.
pub(super) fn only(path: &Path, file: &Hdf5File, others: &Others) -> Result<Dataset, Error> {
    let all = volumes(path, file, |dtype| scalar(dtype).is_some())?;
    match &all[..] {
        [] if !volumes(path, file, is_complex)?.is_empty() => Err(Error::volume(path, format!("it has {COMPLEX}"))),
        [] => {
            let problem = others.problem().unwrap_or_else(|| "it has no dataset of numbers along two axes or more".into());
            Err(Error::volume(path, problem))
        }
        [name] => file.dataset(name).map_err(|e| damaged(path, &e)),
        several => {
            let problem = format!("{} has several datasets: {}; choose one", path.display(), several.join(", "));
            Err(Error::Settings { field: "array", problem })
        }
    }
}

/// Paths of all datasets of numbers along three axes or more; if there are none, of those along two.
fn volumes(path: &Path, file: &Hdf5File, wanted: impl Fn(&Datatype) -> bool) -> Result<Vec<String>, Error> {
    let mut found = Vec::new();
    let visited = each_dataset(file, &mut |name, dataset: Dataset| {
        found.extend(wanted(dataset.dtype()).then(|| (dataset.ndim(), name.to_owned())));
    });
    visited.map_err(|e| damaged(path, &e))?;
    let of =
        |axes: &dyn Fn(usize) -> bool| found.iter().filter(|(n, _)| axes(*n)).map(|(_, name)| name.clone()).collect::<Vec<_>>();
    let volumes = of(&|n| n > 2);
    Ok(if volumes.is_empty() { of(&|n| n == 2) } else { volumes })
}

/// Passes on all datasets with their paths.
pub(super) fn each_dataset(file: &Hdf5File, visit: &mut dyn FnMut(&str, Dataset)) -> Result<(), hdf5_reader::error::Error> {
    let (mut count, mut seen) = (0, BTreeSet::new());
    let mut groups: Vec<(String, Group)> = vec![(String::new(), file.root_group()?)];
    while let Some((prefix, group)) = groups.pop() {
        // Links may reach a group several times, even from inside the group.
        if !seen.insert(group.address()) || count + groups.len() > MOST {
            continue;
        }
        let (below, datasets) = group.members()?;
        let below = below.into_iter().rev().filter(|group| !INTERNAL.contains(&last(group.name())));
        groups.extend(below.map(|group| (format!("{prefix}{}/", last(group.name())), group)));
        count += datasets.len();
        datasets.into_iter().for_each(|dataset| visit(&format!("{prefix}{}", last(dataset.name())), dataset));
    }
    Ok(())
}

/// Last component of a path.
pub(super) fn last(name: &str) -> &str {
    name.trim_end_matches('/').rsplit('/').next().unwrap_or_default()
}
