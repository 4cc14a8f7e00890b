//! Products, units and contexts, which AP214 requires in addition to the faces.

use std::io::Write;

use glam::DVec3;

use super::super::common::uncertainty;
use super::entities::{Entities, list, real, string};
use super::geometry;
use crate::brep::{LengthUnit, Shell};
use crate::error::Result;

/// Entities that all products of a file share.
pub(super) struct Common {
    unit: LengthUnit,
    /// References to the units of length, angle and solid angle.
    units: [String; 3],
    /// The contexts of products and of their definitions.
    contexts: [String; 2],
}

impl Common {
    pub(super) fn write<W: Write>(file: &mut Entities<'_, W>, unit: LengthUnit) -> Result<Self> {
        let length = length_unit(file, unit)?;
        let angle = file.add("(NAMED_UNIT(*) PLANE_ANGLE_UNIT() SI_UNIT($,.RADIAN.))")?;
        let solid = file.add("(NAMED_UNIT(*) SI_UNIT($,.STERADIAN.) SOLID_ANGLE_UNIT())")?;
        let application = file.add("APPLICATION_CONTEXT('automotive design')")?;
        file.add(&format!(
            "APPLICATION_PROTOCOL_DEFINITION('international standard','automotive_design',2000,\
             {application})"
        ))?;
        let product = file.add(&format!("PRODUCT_CONTEXT('',{application},'mechanical')"))?;
        let definition = file.add(&format!(
            "PRODUCT_DEFINITION_CONTEXT('part definition',{application},'design')"
        ))?;
        let (units, contexts) = ([length, angle, solid], [product, definition]);
        Ok(Self { unit, units, contexts })
    }

    /// Writes the geometric context of a shell, with its uncertainty.
    pub(super) fn context<W: Write>(
        &self,
        file: &mut Entities<'_, W>,
        shell: &Shell,
    ) -> Result<String> {
        let [length, angle, solid] = &self.units;
        let precision = file.add(&format!(
            "UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE({}),{length},\
             'distance_accuracy_value','')",
            real(uncertainty(shell, self.unit))
        ))?;
        file.add(&format!(
            "(GEOMETRIC_REPRESENTATION_CONTEXT(3) \
             GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT(({precision})) \
             GLOBAL_UNIT_ASSIGNED_CONTEXT(({length},{angle},{solid})) \
             REPRESENTATION_CONTEXT('',''))"
        ))
    }

    /// Writes a product whose shape is the solids and surfaces in `items`.
    pub(super) fn product<W: Write>(
        &self,
        file: &mut Entities<'_, W>,
        name: &str,
        (kind, items): (&str, Vec<String>),
        context: &str,
    ) -> Result<()> {
        let origin = geometry::point(file, DVec3::ZERO)?;
        let (z, x) = (file.add("DIRECTION('',(0.,0.,1.))")?, file.add("DIRECTION('',(1.,0.,0.))")?);
        let axes = file.add(&format!("AXIS2_PLACEMENT_3D('',{origin},{z},{x})"))?;
        let items = list(std::iter::once(axes).chain(items));
        let shape = file.add(&format!("{kind}('',{items},{context})"))?;
        let (name, [mechanical, design]) = (string(name), &self.contexts);
        let product = file.add(&format!("PRODUCT({name},{name},'',({mechanical}))"))?;
        let formation = file.add(&format!("PRODUCT_DEFINITION_FORMATION('','',{product})"))?;
        let definition =
            file.add(&format!("PRODUCT_DEFINITION('design','',{formation},{design})"))?;
        let defined = file.add(&format!("PRODUCT_DEFINITION_SHAPE('','',{definition})"))?;
        file.add(&format!("SHAPE_DEFINITION_REPRESENTATION({defined},{shape})"))?;
        Ok(())
    }
}

/// Writes the unit of length. Inches and feet are defined by millimeters.
fn length_unit<W: Write>(file: &mut Entities<'_, W>, unit: LengthUnit) -> Result<String> {
    let (prefix, name) = match unit {
        LengthUnit::Millimeter => (".MILLI.", None),
        LengthUnit::Centimeter => (".CENTI.", None),
        LengthUnit::Meter => ("$", None),
        LengthUnit::Inch => (".MILLI.", Some("INCH")),
        LengthUnit::Foot => (".MILLI.", Some("FOOT")),
    };
    let metric = file.add(&format!("(LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT({prefix},.METRE.))"))?;
    let Some(name) = name else {
        return Ok(metric);
    };
    let millimeters = real(unit.in_millimeters());
    let factor =
        file.add(&format!("LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE({millimeters}),{metric})"))?;
    let dimension = file.add("DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.)")?;
    file.add(&format!(
        "(CONVERSION_BASED_UNIT('{name}',{factor}) LENGTH_UNIT() NAMED_UNIT({dimension}))"
    ))
}
