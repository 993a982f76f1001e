//! Nodes of a Zarr hierarchy: groups and arrays.

use super::array::Array;
use super::multiscales::Multiscales;
use super::store::{self, Store};
use crate::error::Error;
use crate::volume::format::numbered;
use serde_json::Value;
use std::io;
use std::path::Path;

/// Metadata files that mark a node.
const MARKS: [&str; 3] = ["zarr.json", ".zarray", ".zgroup"];
/// Largest metadata file in bytes. The metadata of a group may include those of all its members.
const LONGEST: u64 = 64 << 20;
/// Limits of nested groups and of arrays found.
const DEEPEST: usize = 6;
const MOST_ARRAYS: usize = 1000;
/// Limit of wells of a plate whose images are found: each takes requests of its own.
const MOST_WELLS: usize = 16;

/// What metadata of version 3 may hold besides extensions.
const KNOWN: [&str; 12] = [
    "zarr_format",
    "node_type",
    "shape",
    "data_type",
    "chunk_grid",
    "chunk_key_encoding",
    "fill_value",
    "codecs",
    "attributes",
    "storage_transformers",
    "dimension_names",
    "consolidated_metadata",
];

/// Whether a folder is a Zarr node.
pub(super) fn is_node(folder: &Path) -> bool {
    MARKS.iter().any(|mark| folder.join(mark).is_file())
}

/// A node.
pub(super) enum Node {
    Array(Box<Array>),
    Image(Multiscales),
    Group,
}

/// Reads the metadata of a folder.
///
/// # Errors
/// [`Error::Volume`] if it is no node, or an unusual one.
pub(super) fn node(folder: &Path) -> Result<Node, Error> {
    found(folder)?.ok_or_else(|| {
        Error::volume(
            folder,
            format!(
                "there is no {}: it is no Zarr array or group; files of other formats are read once they are downloaded",
                MARKS.join(", ")
            ),
        )
    })
}

/// The node of a folder; `None` if the folder is none.
pub(super) fn found(folder: &Path) -> Result<Option<Node>, Error> {
    let wrong = |problem: String| Error::volume(folder, problem);
    let store = store::of(folder);
    let Some(Metadata { metadata, attributes, is_array }) = read(&*store, folder)? else { return Ok(None) };
    if !(metadata["zarr_format"] == 2 || metadata["zarr_format"] == 3) {
        return Err(wrong(format!("its zarr_format is {}: expected 2 or 3", metadata["zarr_format"])));
    }
    if metadata["zarr_format"] == 3 {
        understood(&metadata).map_err(wrong)?;
    }
    if is_array {
        let array = Array::new(store, folder, &metadata, &attributes).map_err(wrong)?;
        return Ok(Some(Node::Array(Box::new(array))));
    }
    Ok(Some(Multiscales::new(&attributes).map_err(wrong)?.map_or(Node::Group, Node::Image)))
}

/// Fails on extensions of version 3 that change what the bytes mean.
fn understood(metadata: &Value) -> Result<(), String> {
    if let Some(transformer) = metadata["storage_transformers"].as_array().and_then(|all| all.first()) {
        let name = if transformer.is_string() { transformer } else { &transformer["name"] };
        return Err(format!("it has the storage transformer {name}, which is not supported"));
    }
    let extensions = metadata.as_object().into_iter().flatten().filter(|(name, _)| !KNOWN.contains(&name.as_str()));
    let mut required = extensions.filter(|(_, value)| value["must_understand"] != false);
    match required.next() {
        Some((name, _)) => Err(format!("it has the extension {name}, which is not supported, but must be understood")),
        None => Ok(()),
    }
}

/// A value of a folder's OME metadata: below `ome` from version 0.5 on. Null if it is missing.
pub(super) fn ome(folder: &Path, key: &str) -> Result<Value, Error> {
    let attributes = read(&*store::of(folder), folder)?.map_or(Value::Null, |found| found.attributes);
    Ok(within_ome(&attributes)[key].clone())
}

/// The OME metadata of attributes: below `ome` from version 0.5 on.
fn within_ome(attributes: &Value) -> &Value {
    if attributes["ome"].is_object() { &attributes["ome"] } else { attributes }
}

/// Whether a server refuses metadata. Object stores that do not list answer so for what is not there.
pub(super) fn is_refused(error: &Error) -> bool {
    matches!(error, Error::Read { source, .. } if source.kind() == io::ErrorKind::PermissionDenied)
}

/// What a folder states.
struct Metadata {
    metadata: Value,
    attributes: Value,
    is_array: bool,
}

/// The metadata of a folder; `None` if it has none. Object stores that do not list refuse files that are not there: what is refused is an error
/// only where nothing else is found.
fn read(store: &dyn Store, folder: &Path) -> Result<Option<Metadata>, Error> {
    let mut refused = None;
    let mut if_allowed = |name: &str| match json(store, &folder.join(name)) {
        Err(Error::Read { path, source }) if source.kind() == io::ErrorKind::PermissionDenied => {
            refused.get_or_insert(Error::Read { path, source });
            Ok(None)
        }
        other => other,
    };
    if let Some(mut metadata) = if_allowed(MARKS[0])? {
        for (path, below) in metadata["consolidated_metadata"]["metadata"].as_object().into_iter().flatten() {
            if numbered::leads_below(path) {
                store.keep(folder.join(path).join(MARKS[0]), below);
            }
        }
        let (attributes, is_array) = (metadata["attributes"].take(), metadata["node_type"] == "array");
        return Ok(Some(Metadata { metadata, attributes, is_array }));
    }
    let array = if_allowed(MARKS[1])?;
    let is_array = array.is_some();
    let Some(metadata) = array.map_or_else(|| if_allowed(MARKS[2]), |array| Ok(Some(array)))? else {
        return refused.map_or(Ok(None), Err);
    };
    let attributes = match json(store, &folder.join(".zattrs")) {
        // As what is not there was, before.
        Err(Error::Read { source, .. }) if refused.is_some() && source.kind() == io::ErrorKind::PermissionDenied => None,
        other => other?,
    };
    let attributes = attributes.unwrap_or(Value::Null);
    Ok(Some(Metadata { metadata, attributes, is_array }))
}

/// A metadata file; `None` if there is none.
fn json(store: &dyn Store, file: &Path) -> Result<Option<Value>, Error> {
    let text = store.metadata(file, LONGEST).map_err(|e| match e.kind() {
        io::ErrorKind::InvalidData => Error::volume(file, e.to_string()),
        _ => Error::read(file, e),
    })?;
    let damaged = |e| Error::volume(file, format!("it is truncated or damaged: {e}"));
    text.map(|text| serde_json::from_slice(&text).map_err(damaged)).transpose()
}

/// Paths of the arrays and images in a group.
///
/// # Errors
/// [`Error::Volume`] if the store has no lists, and the group's metadata name none.
pub(super) fn below(group: &Path) -> Result<Vec<String>, Error> {
    let store = store::of(group);
    let mut found = Vec::new();
    match store.folders(group).map_err(|e| Error::read(group, e))? {
        Some(names) => gather(&*store, group, names, "", DEEPEST, &mut found)?,
        None => found = named(&*store, group)?,
    }
    Ok(found)
}

/// Paths of the images that the metadata of a group name: of labels, of a well, of a plate, or of a `bioformats2raw` layout.
fn named(store: &dyn Store, group: &Path) -> Result<Vec<String>, Error> {
    let metadata = |folder: &Path| read(store, folder).map(|found| found.map_or(Value::Null, |found| found.attributes));
    let attributes = metadata(group)?;
    let ome = within_ome(&attributes);
    let mut names = paths(&ome["labels"]);
    names.extend(paths(&ome["well"]["images"]));
    for well in paths(&ome["plate"]["wells"]).iter().take(MOST_WELLS) {
        let images = paths(&within_ome(&metadata(&group.join(well))?)["well"]["images"]);
        names.extend(images.iter().map(|image| format!("{well}/{image}")));
    }
    if names.is_empty() && !ome["bioformats2raw.layout"].is_null() {
        names = match metadata(&group.join("OME")) {
            Err(e) if is_refused(&e) => Vec::new(),
            found => paths(&within_ome(&found?)["series"]),
        };
        // Without a list, they are numbered.
        let is_listed = !names.is_empty();
        while !is_listed && names.len() < MOST_ARRAYS {
            match found(&group.join(names.len().to_string())) {
                Ok(Some(_)) => names.push(names.len().to_string()),
                Ok(None) => break,
                Err(e) if is_refused(&e) && !names.is_empty() => break,
                Err(e) => return Err(e),
            }
        }
    }
    if names.is_empty() {
        let problem = "it is a group whose metadata name no images, and web servers have no lists: name an array of it";
        return Err(Error::volume(group, problem));
    }
    names.truncate(MOST_ARRAYS);
    Ok(names)
}

/// The paths of a list of paths, or of objects that have one, that lead below the group.
fn paths(list: &Value) -> Vec<String> {
    let paths = list.as_array().into_iter().flatten().filter_map(|one| one.as_str().or(one["path"].as_str()));
    paths.filter(|path| numbered::leads_below(path)).map(String::from).collect()
}

fn gather(
    store: &dyn Store,
    group: &Path,
    mut names: Vec<String>,
    prefix: &str,
    deep: usize,
    found: &mut Vec<String>,
) -> Result<(), Error> {
    names.sort_by_key(|name| (name.len(), name.clone()));
    for name in names {
        let (path, folder) = (format!("{prefix}{name}"), group.join(&name));
        match self::found(&folder)? {
            None => {}
            _ if found.len() >= MOST_ARRAYS => break,
            Some(Node::Group) if deep > 0 => {
                let names = store.folders(&folder).map_err(|e| Error::read(&folder, e))?.unwrap_or_default();
                gather(store, &folder, names, &format!("{path}/"), deep - 1, found)?;
            }
            Some(Node::Group) => {}
            Some(Node::Array(_) | Node::Image(_)) => found.push(path),
        }
    }
    Ok(())
}
