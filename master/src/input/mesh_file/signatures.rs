//! Signs by which formats that are not read are recognised.

/// First bytes of an HDF5 file.
const HDF5: &[u8] = b"\x89HDF\r\n\x1a\n";

/// Returns true for an HDF5 file that has one of these names. They may be anywhere in the file, so
/// `bytes` should be all of it.
fn is_hdf5_with(bytes: &[u8], names: &[&[u8]]) -> bool {
    let has = |name: &&[u8]| bytes.windows(name.len()).any(|window| window == *name);
    is_hdf5(bytes) && names.iter().any(has)
}

/// Returns true for any HDF5 file.
pub fn is_hdf5(head: &[u8]) -> bool {
    head.starts_with(HDF5)
}

/// Returns true for a model of EXODUS II in netCDF-4, which is HDF5: it has one of these
/// dimensions.
pub fn is_exodus_in_hdf5(bytes: &[u8]) -> bool {
    is_hdf5_with(bytes, &[b"num_nodes", b"num_dim"])
}

/// Returns true for VTKHDF: its only group has this name.
pub fn is_vtkhdf(bytes: &[u8]) -> bool {
    is_hdf5_with(bytes, &[b"VTKHDF"])
}

/// Returns true for MED, by the group of its meshes or that of its version.
pub fn is_med(bytes: &[u8]) -> bool {
    is_hdf5_with(bytes, &[b"ENS_MAA", b"INFOS_GENERALES"])
}

/// Returns true for CGNS in HDF5, by its version or the label of its bases, or in ADF.
pub fn is_cgns(bytes: &[u8]) -> bool {
    is_hdf5_with(bytes, &[b"CGNSLibraryVersion", b"CGNSBase_t"])
        || bytes.get(4..).is_some_and(|rest| rest.starts_with(b"ADF Database"))
}

/// Lines of a Wavefront OBJ by which it is recognised.
const OBJ_LINES: usize = 50;
/// First words of these lines.
const OBJ_WORDS: [&str; 12] =
    ["v", "vn", "vt", "vp", "f", "l", "p", "o", "g", "s", "mtllib", "usemtl"];

/// Returns true for a Wavefront OBJ: its lines begin with known words, and one has a point.
pub fn is_obj(head: &[u8]) -> bool {
    let text = String::from_utf8_lossy(head).into_owned();
    let lines = text.lines().map(str::trim).filter(|l| !l.is_empty() && !l.starts_with('#'));
    let mut has_point = false;
    for line in lines.take(OBJ_LINES) {
        let mut words = line.split_whitespace();
        let first = words.next().unwrap_or_default();
        if !OBJ_WORDS.contains(&first) {
            return false;
        }
        has_point |= first == "v" && words.filter(|w| w.parse::<f64>().is_ok()).count() >= 3;
    }
    has_point
}

/// Returns true for an OFF file, whose first word may have letters for normals and colours.
pub fn is_off(head: &[u8]) -> bool {
    let text = String::from_utf8_lossy(head).into_owned();
    let first = text.lines().map(str::trim).find(|l| !l.is_empty() && !l.starts_with('#'));
    let word = first.and_then(|line| line.split_whitespace().next()).unwrap_or_default();
    word.strip_suffix("OFF").is_some_and(|rest| rest.chars().all(|c| "STCN4n".contains(c)))
}

/// Words of the control section of d3plot, from 0: dimension, number of nodes, kind of database,
/// and the flags of coordinates, velocities and accelerations.
const D3PLOT_WORDS: [usize; 6] = [15, 16, 17, 20, 21, 22];

/// Returns true for the first file of a d3plot database, with words of 4 or 8 bytes.
pub fn is_d3plot(head: &[u8]) -> bool {
    let fits = |word: &dyn Fn(usize) -> Option<u64>| {
        let [Some(dimension), Some(nodes), Some(kind), x, v, a] = D3PLOT_WORDS.map(word) else {
            return false;
        };
        let has_flags = [x, v, a].into_iter().all(|flag| flag.is_some_and(|flag| flag <= 1));
        (2..=7).contains(&dimension) && nodes > 0 && matches!(kind, 2 | 6) && has_flags
    };
    let four = |i: usize| <[u8; 4]>::try_from(head.get(4 * i..4 * i + 4)?).ok();
    let eight = |i: usize| <[u8; 8]>::try_from(head.get(8 * i..8 * i + 8)?).ok();
    fits(&|i| four(i).map(|b| u32::from_le_bytes(b).into()))
        || fits(&|i| four(i).map(|b| u32::from_be_bytes(b).into()))
        || fits(&|i| eight(i).map(u64::from_le_bytes))
        || fits(&|i| eight(i).map(u64::from_be_bytes))
}
