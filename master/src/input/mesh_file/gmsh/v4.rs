//! Sections of MSH 4.1.

use super::stream::RowFault;
use super::{MshElement, MshReader, cell_of};
use crate::input::mesh_file::content::FileNode;

impl MshReader<'_, '_> {
    /// Reads the physical groups of the entities.
    pub fn entities(&mut self) -> Result<(), RowFault> {
        let stream = &mut self.stream;
        stream.begin_row()?;
        let counts = [stream.size()?, stream.size()?, stream.size()?, stream.size()?];
        stream.end_row()?;
        for (dimension, count) in counts.into_iter().enumerate() {
            for _ in 0..count {
                stream.begin_row()?;
                let tag = stream.int()?;
                // A point has coordinates, all others a box.
                for _ in 0..(if dimension == 0 { 3 } else { 6 }) {
                    stream.double()?;
                }
                let mut groups = Vec::new();
                for _ in 0..stream.size()? {
                    groups.push(stream.int()?.saturating_abs());
                }
                if dimension > 0 {
                    for _ in 0..stream.size()? {
                        stream.int()?;
                    }
                }
                stream.end_row()?;
                self.content.entities.insert((dimension, tag), groups);
            }
        }
        Ok(())
    }

    /// Reads blocks of nodes: first all tags, then all coordinates.
    pub fn nodes_4(&mut self) -> Result<(), RowFault> {
        self.stream.begin_row()?;
        let [blocks, total, _, _] = self.four_sizes()?;
        for _ in 0..blocks {
            self.stream.begin_row()?;
            let (dimension, _tag) = (self.stream.int()?, self.stream.int()?);
            let (parametric, count) = (self.stream.int()?, self.stream.size()?);
            self.stream.end_row()?;
            let first = self.content.nodes.len();
            for _ in 0..count {
                self.stream.begin_row()?;
                let id = self.stream.size()?;
                self.stream.end_row()?;
                let place = self.place();
                self.content.nodes.push(FileNode { id, x: [0.0; 3], place });
            }
            let parameters = if parametric == 0 { 0 } else { dimension.clamp(0, 3) };
            for index in first..self.content.nodes.len() {
                self.stream.begin_row()?;
                let place = self.place();
                match self.stream.point() {
                    Ok(x) => {
                        let id = self.content.nodes[index].id;
                        self.content.nodes[index] = FileNode { id, x, place };
                        for _ in 0..parameters {
                            self.stream.double()?;
                        }
                        self.stream.end_row()?;
                    }
                    Err(fault) if fault.fatal => return Err(fault),
                    Err(fault) => self.fault("$Nodes", &fault),
                }
            }
        }
        self.check_count("$Nodes", total, self.content.nodes.len());
        Ok(())
    }

    /// Reads blocks of elements of one entity and type.
    pub fn elements_4(&mut self) -> Result<(), RowFault> {
        self.stream.begin_row()?;
        let [blocks, total, _, _] = self.four_sizes()?;
        for _ in 0..blocks {
            self.stream.begin_row()?;
            let (dimension, entity) = (self.stream.int()?, self.stream.int()?);
            let kind = self.stream.int()?;
            let count = self.stream.size()?;
            self.stream.end_row()?;
            let (cell, width) = cell_of(kind)?;
            let groups = self.content.entities.get(&(dimension.clamp(0, 3) as usize, entity));
            let groups = groups.cloned().unwrap_or_default();
            for _ in 0..count {
                self.stream.begin_row()?;
                match self.tag_and_corners(width) {
                    Ok((id, corners)) => {
                        let (groups, place) = (groups.clone(), self.place());
                        let element = MshElement { id, cell, entity, groups, corners, place };
                        self.content.elements.push(element);
                    }
                    Err(fault) if fault.fatal => return Err(fault),
                    Err(fault) => self.fault("$Elements", &fault),
                }
            }
        }
        self.check_count("$Elements", total, self.content.elements.len());
        Ok(())
    }

    fn tag_and_corners(&mut self, width: usize) -> Result<(u64, Vec<u64>), RowFault> {
        let id = self.stream.size()?;
        let corners = (0..width).map(|_| self.stream.size()).collect::<Result<_, _>>()?;
        self.stream.end_row()?;
        Ok((id, corners))
    }

    fn four_sizes(&mut self) -> Result<[u64; 4], RowFault> {
        let stream = &mut self.stream;
        let sizes = [stream.size()?, stream.size()?, stream.size()?, stream.size()?];
        stream.end_row()?;
        Ok(sizes)
    }
}
