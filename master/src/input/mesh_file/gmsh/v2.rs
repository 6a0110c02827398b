//! Sections of MSH 2.2.

use super::stream::{MshForm, RowFault};
use super::{MshElement, MshReader, cell_of};
use crate::input::mesh_file::content::FileNode;
use crate::input::mesh_file::shortened;

impl MshReader<'_, '_> {
    /// Reads the number of rows, which is text also in binary files.
    fn count(&mut self) -> Result<u64, RowFault> {
        let line = self.stream.text_line().unwrap_or_default();
        line.parse().map_err(|_| RowFault {
            message: format!("the number of rows is expected, not `{}`", shortened(line)),
            fatal: true,
        })
    }

    /// Reads nodes: tag and coordinates.
    pub fn nodes_2(&mut self) -> Result<(), RowFault> {
        let count = self.count()?;
        for _ in 0..count {
            self.stream.begin_row()?;
            let place = self.place();
            let mut row = || {
                let (id, x) = (self.stream.int()?, self.stream.point()?);
                self.stream.end_row()?;
                Ok((id, x))
            };
            match row() {
                Ok((id, x)) => match u64::try_from(id) {
                    Ok(id) => self.content.nodes.push(FileNode { id, x, place }),
                    Err(_) => self.bad_id(id),
                },
                Err(fault @ RowFault { fatal: true, .. }) => return Err(fault),
                Err(fault) => self.fault("$Nodes", &fault),
            }
        }
        self.check_count("$Nodes", count, self.content.nodes.len());
        Ok(())
    }

    /// Reads elements: tag, type, tags and nodes. In binary files they come in groups of one type.
    pub fn elements_2(&mut self) -> Result<(), RowFault> {
        let total = self.count()?;
        if self.stream.form == MshForm::Text {
            for _ in 0..total {
                self.stream.begin_row()?;
                match self.element_row() {
                    Err(fault) if fault.fatal => return Err(fault),
                    Err(fault) => self.fault("$Elements", &fault),
                    Ok(()) => {}
                }
            }
        } else {
            while (self.content.elements.len() as u64) < total {
                let (kind, count) = (self.stream.int()?, self.stream.int()?);
                let tags = self.stream.int()?;
                if count < 1 {
                    let message = format!("a group has {count} elements");
                    return Err(RowFault { message, fatal: true });
                }
                for _ in 0..count {
                    let id = self.stream.int()?;
                    self.element(id, kind, tags)?;
                }
            }
        }
        self.check_count("$Elements", total, self.content.elements.len());
        Ok(())
    }

    fn element_row(&mut self) -> Result<(), RowFault> {
        let (id, kind, tags) = (self.stream.int()?, self.stream.int()?, self.stream.int()?);
        self.element(id, kind, tags)
    }

    /// Reads tags and nodes. The first two tags are the physical group and the entity.
    fn element(&mut self, id: i64, kind: i64, count: i64) -> Result<(), RowFault> {
        if count < 0 {
            let message = format!("{count} is no number of tags");
            return Err(RowFault { message, fatal: false });
        }
        let mut tags = Vec::new();
        for _ in 0..count {
            tags.push(self.stream.int()?);
        }
        let (cell, width) = cell_of(kind)?;
        let mut corners = Vec::with_capacity(width);
        for _ in 0..width {
            let corner = self.stream.int()?;
            match u64::try_from(corner) {
                Ok(corner) => corners.push(corner),
                Err(_) => self.bad_id(corner),
            }
        }
        self.stream.end_row()?;
        let groups = tags
            .first()
            .map(|tag| tag.saturating_abs())
            .filter(|&tag| tag > 0)
            .into_iter()
            .collect();
        let (entity, place) = (tags.get(1).copied().unwrap_or(0), self.place());
        match u64::try_from(id) {
            Ok(id) => {
                let element = MshElement { id, cell, entity, groups, corners, place };
                self.content.elements.push(element);
            }
            Err(_) => self.bad_id(id),
        }
        Ok(())
    }

    fn bad_id(&mut self, id: i64) {
        let place = self.place();
        self.reading.error("id", place, format!("{id} is no id"), "ids are whole numbers from 0");
    }
}
