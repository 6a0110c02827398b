//! Lines of an Abaqus input file: keywords with parameters, and their lines of data.

use crate::input::mesh_file::content::FilePlace;
use crate::input::mesh_file::reading::MeshReading;

/// A keyword with its lines of data.
#[derive(Clone)]
pub struct AbaqusBlock {
    /// Keyword in capitals, without the asterisk.
    pub keyword: String,
    /// Parameters: name in capitals, and value; empty without one.
    pub parameters: Vec<(String, String)>,
    /// Lines of data: fields without blanks around them.
    pub data: Vec<DataLine>,
    /// Its place.
    pub place: FilePlace,
}

/// A line of data.
#[derive(Clone)]
pub struct DataLine {
    /// Fields.
    pub fields: Vec<String>,
    /// True if it ends with a comma, so that the next line may continue it.
    pub open: bool,
    /// Its place.
    pub place: FilePlace,
}

impl AbaqusBlock {
    /// Returns the value of a parameter.
    pub fn value(&self, name: &str) -> Option<&str> {
        self.parameters.iter().find(|p| p.0 == name).map(|p| p.1.as_str())
    }

    /// Returns true if it has this parameter.
    pub fn has(&self, name: &str) -> bool {
        self.value(name).is_some()
    }
}

/// Returns all keywords of a file and of those that it includes.
pub fn blocks(reading: &mut MeshReading, bytes: &[u8]) -> Vec<AbaqusBlock> {
    let mut found = Vec::new();
    add_file(reading, bytes, 0, &mut found);
    found
}

fn add_file(reading: &mut MeshReading, bytes: &[u8], file: u32, found: &mut Vec<AbaqusBlock>) {
    let text = String::from_utf8_lossy(bytes).into_owned();
    let mut lines = text.lines().zip(1..).peekable();
    while let Some((line, number)) = lines.next() {
        let place = FilePlace { file, line: number };
        let line = line.trim();
        if line.starts_with("**") || line.is_empty() {
            continue;
        }
        let Some(first) = line.strip_prefix('*') else {
            add_data(reading, line, place, found);
            continue;
        };
        let mut keyword = first.trim().to_string();
        // A comma at the end continues the line.
        while keyword.ends_with(',') {
            match lines.next_if(|(next, _)| !next.trim().starts_with('*')) {
                Some((next, _)) => keyword += next.trim(),
                None => break,
            }
        }
        let block = parsed(&keyword, place);
        if block.keyword == "INCLUDE" {
            let Some(name) = block.value("INPUT").filter(|name| !name.is_empty()) else {
                let message = "*INCLUDE has no INPUT=FILE";
                reading.error("include", place, message, "name the file: *INCLUDE, INPUT=FILE");
                continue;
            };
            if let Some((file, bytes)) = reading.include(name, place) {
                add_file(reading, &bytes, file, found);
            }
            continue;
        }
        found.push(block);
    }
}

fn add_data(reading: &mut MeshReading, line: &str, place: FilePlace, found: &mut [AbaqusBlock]) {
    let Some(block) = found.last_mut() else {
        let message = "a keyword is expected, and the line has none";
        reading.error("keyword", place, message, "a keyword begins with `*`, such as *NODE");
        return;
    };
    let mut fields: Vec<String> = line.split(',').map(|f| f.trim().to_string()).collect();
    let open = fields.last().is_some_and(String::is_empty);
    if open {
        fields.pop();
    }
    block.data.push(DataLine { fields, open, place });
}

fn parsed(line: &str, place: FilePlace) -> AbaqusBlock {
    let mut words = line.split(',').map(str::trim);
    let upper = |word: &str| word.split_whitespace().collect::<Vec<_>>().join(" ").to_uppercase();
    let keyword = upper(words.next().unwrap_or_default());
    let parameter = |word: &str| match word.split_once('=') {
        Some((name, value)) => (upper(name), value.trim().trim_matches('"').to_string()),
        None => (upper(word), String::new()),
    };
    let parameters = words.filter(|word| !word.is_empty()).map(parameter).collect();
    AbaqusBlock { keyword, parameters, data: Vec::new(), place }
}
