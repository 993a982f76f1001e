//! ParaView's collections of files in time, `.pvd` (<https://www.paraview.org/Wiki/ParaView/Data_formats#PVD_File_Format>).

use super::document::attribute;
use crate::error::Error;
use quick_xml::events::Event;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

/// Limit of the bytes parsed as XML.
const LARGEST: u64 = 1 << 24;

/// Times and names of the files of a collection in the order of time.
///
/// # Errors
/// [`Error::Volume`] if it is damaged or empty, or if steps consist of several parts.
pub(in crate::volume::format) fn steps(path: &Path) -> Result<Vec<(f64, String)>, Error> {
    let wrong = |problem: String| Error::volume(path, problem);
    let file = File::open(path).map_err(|e| Error::read(path, e))?;
    let mut reader = quick_xml::Reader::from_reader(BufReader::new(file).take(LARGEST));
    let (mut steps, mut buffer): (Vec<(f64, String)>, _) = (Vec::new(), Vec::new());
    let mut is_complete = false;
    loop {
        buffer.clear();
        match reader.read_event_into(&mut buffer).map_err(|e| wrong(format!("its XML is damaged: {e}")))? {
            Event::Start(tag) | Event::Empty(tag) if tag.local_name().as_ref() == b"DataSet" => {
                let n = steps.len();
                let name = attribute(&tag, "file").ok_or_else(|| wrong(format!("its DataSet {n} names no file")))?;
                let time = attribute(&tag, "timestep").unwrap_or_default();
                let moment = time.trim().parse().ok().filter(|time: &f64| time.is_finite());
                let moment = moment.ok_or_else(|| wrong(format!("the timestep of {name} is '{time}': expected a number")))?;
                steps.push((moment, name));
            }
            Event::End(tag) if tag.local_name().as_ref() == b"VTKFile" => is_complete = true,
            Event::Eof => break,
            _ => {}
        }
    }
    if !is_complete {
        return Err(wrong("it ends before its last tag: it is truncated".into()));
    }
    steps.sort_by(|a, b| a.0.total_cmp(&b.0));
    if let Some(pair) = steps.windows(2).find(|pair| pair[0].0 == pair[1].0) {
        let [(time, a), (_, b)] = [&pair[0], &pair[1]];
        let problem = format!("at time {time} it has two files, {a} and {b}: save each time step as a single file");
        return Err(wrong(problem));
    }
    if steps.is_empty() {
        return Err(wrong("it names no files: expected a Collection of DataSets".into()));
    }
    Ok(steps)
}
