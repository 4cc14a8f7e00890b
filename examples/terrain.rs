//! The whole job on real terrain: `cargo run --release --example terrain`.
//!
//! Reads `examples/jacksboro.xyz` and writes `jacksboro.step` and `jacksboro.obj`.

use std::fs::{self, File};
use std::io::BufWriter;
use std::ops::ControlFlow;

use neurbs::export::{self, StepOptions};
use neurbs::{DVec3, Progress, ReconstructOptions, Shell, reconstruct};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let text = fs::read_to_string("examples/jacksboro.xyz")?;
    let rows = text.lines().filter(|line| !line.starts_with('#'));
    let points = rows.map(point).collect::<Result<Vec<DVec3>, _>>()?;

    let mut percent = 0;
    let mut watch = |progress: &Progress| {
        let now = 100 * progress.step / progress.total.max(1);
        if now >= percent + 10 {
            percent = now;
            println!("{} {now} %, {} points reached", progress.stage.name(), progress.reached);
        }
        ControlFlow::Continue(())
    };
    let result = reconstruct(&points, &ReconstructOptions::default(), &mut watch)?;

    let report = &result.report;
    let ((rows, cols), deviations) = (report.grid, report.deviations);
    println!("{rows} × {cols} control points, ended by: {}", report.ended_by.name());
    println!(
        "distance to the surface: rms {:.1} m, at most {:.1} m",
        deviations.rms, deviations.max
    );
    let mesh = result.tessellate(&mut watch)?;
    let shell = Shell::whole(result.surface)?;
    let mut step = BufWriter::new(File::create("jacksboro.step")?);
    export::write_step(&[shell], &StepOptions::default(), &mut step)?;
    export::write_obj(mesh.view(), &mut BufWriter::new(File::create("jacksboro.obj")?))?;
    Ok(())
}

fn point(line: &str) -> Result<DVec3, String> {
    let numbers = line.split_whitespace().map(str::parse).collect::<Result<Vec<f64>, _>>();
    let coordinates = numbers.map_err(|error| format!("{line}: {error}"))?;
    let [x, y, z] = coordinates[..] else {
        return Err(format!("{line}: x, y and z are needed"));
    };
    Ok(DVec3::new(x, y, z))
}
