//! Colors of faces as styled items.

use std::io::Write;

use super::entities::{Entities, list, real};
use crate::brep::Face;
use crate::error::Result;

/// Writes the colors of the faces that have one; `written` are the references to the faces.
pub(super) fn colors<W: Write>(
    file: &mut Entities<'_, W>,
    faces: &[Face],
    written: &[String],
    context: &str,
) -> Result<()> {
    let mut styled = vec![];
    for (face, reference) in faces.iter().zip(written) {
        let Some([red, green, blue]) = face.color().map(|color| color.map(real)) else { continue };
        let color = file.add(&format!("COLOUR_RGB('',{red},{green},{blue})"))?;
        let fill = file.add(&format!("FILL_AREA_STYLE_COLOUR('',{color})"))?;
        let fill = file.add(&format!("FILL_AREA_STYLE('',({fill}))"))?;
        let fill = file.add(&format!("SURFACE_STYLE_FILL_AREA({fill})"))?;
        let side = file.add(&format!("SURFACE_SIDE_STYLE('',({fill}))"))?;
        let usage = file.add(&format!("SURFACE_STYLE_USAGE(.BOTH.,{side})"))?;
        let style = file.add(&format!("PRESENTATION_STYLE_ASSIGNMENT(({usage}))"))?;
        styled.push(file.add(&format!("STYLED_ITEM('color',({style}),{reference})"))?);
    }
    if !styled.is_empty() {
        let items = list(styled);
        file.add(&format!(
            "MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION('',{items},{context})"
        ))?;
    }
    Ok(())
}
