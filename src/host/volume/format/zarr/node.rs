//! Nodes of a Zarr hierarchy: groups and arrays.

use super::array::Array;
use super::multiscales::Multiscales;
use crate::error::Error;
use crate::memory;
use serde_json::Value;
use std::path::Path;

/// Metadata files that mark a node.
const MARKS: [&str; 3] = ["zarr.json", ".zarray", ".zgroup"];
/// Largest metadata file in bytes. The metadata of a group may include those of all its members.
const LONGEST: u64 = 64 << 20;
/// Limits of nested groups and of arrays found.
const DEEPEST: usize = 6;
const MOST_ARRAYS: usize = 1000;

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
pub(super) fn node(folder: &Path) -> Result<Node, Error> {
    let wrong = |problem: String| Error::volume(folder, problem);
    let (metadata, attributes, is_array) = read(folder)?;
    if !(metadata["zarr_format"] == 2 || metadata["zarr_format"] == 3) {
        return Err(wrong(format!("its zarr_format is {}: expected 2 or 3", metadata["zarr_format"])));
    }
    if is_array {
        return Array::new(folder, &metadata, &attributes).map(|array| Node::Array(Box::new(array))).map_err(wrong);
    }
    Ok(Multiscales::new(&attributes).map_err(wrong)?.map_or(Node::Group, Node::Image))
}

/// A value of a folder's OME metadata: below `ome` from version 0.5 on. Null if it is missing.
pub(super) fn ome(folder: &Path, key: &str) -> Result<Value, Error> {
    let (_, mut attributes, _) = read(folder)?;
    let within = if attributes["ome"].is_object() { attributes["ome"].take() } else { attributes };
    Ok(within[key].clone())
}

/// Metadata and attributes of a folder, and whether it is an array.
fn read(folder: &Path) -> Result<(Value, Value, bool), Error> {
    let third = folder.join(MARKS[0]);
    if third.is_file() {
        let metadata = json(&third)?;
        let (attributes, is_array) = (metadata["attributes"].clone(), metadata["node_type"] == "array");
        return Ok((metadata, attributes, is_array));
    }
    let (array, attributes) = (folder.join(MARKS[1]), folder.join(".zattrs"));
    let is_array = array.is_file();
    let attributes = if attributes.is_file() { json(&attributes)? } else { Value::Null };
    Ok((json(&if is_array { array } else { folder.join(MARKS[2]) })?, attributes, is_array))
}

fn json(path: &Path) -> Result<Value, Error> {
    let len = std::fs::metadata(path).map_err(|e| Error::read(path, e))?.len();
    if len > LONGEST {
        return Err(Error::volume(path, format!("it has {len} bytes: too many for array metadata")));
    }
    memory::require(&path.display().to_string(), len)?;
    let text = std::fs::read(path).map_err(|e| Error::read(path, e))?;
    serde_json::from_slice(&text).map_err(|e| Error::volume(path, format!("it is truncated or damaged: {e}")))
}

/// Paths of the arrays and images in a group.
pub(super) fn below(group: &Path) -> Result<Vec<String>, Error> {
    let mut found = Vec::new();
    gather(group, "", DEEPEST, &mut found)?;
    Ok(found)
}

fn gather(group: &Path, prefix: &str, deep: usize, found: &mut Vec<String>) -> Result<(), Error> {
    let failed = |e| Error::read(group, e);
    let mut names = Vec::new();
    for entry in std::fs::read_dir(group).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        if let Some(name) = path.file_name().and_then(|name| name.to_str()).filter(|_| path.is_dir() && is_node(&path)) {
            names.push(name.to_owned());
        }
    }
    names.sort_by_key(|name| (name.len(), name.clone()));
    for name in names {
        let (path, folder) = (format!("{prefix}{name}"), group.join(&name));
        match node(&folder)? {
            _ if found.len() >= MOST_ARRAYS => break,
            Node::Group if deep > 0 => gather(&folder, &format!("{path}/"), deep - 1, found)?,
            Node::Group => {}
            Node::Array(_) | Node::Image(_) => found.push(path),
        }
    }
    Ok(())
}
