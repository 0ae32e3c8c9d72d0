//! Files of paths for pages: cycle files, as in `stepwright cycle`, and G-code jobs, as in
//! `stepwright gcode`. The extension of the file's name tells the kind.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use stepwright_keeper::Declined;
use stepwright_keeper::report::PathReport;
use stepwright_keeper::report::Trouble;
use stepwright_path::AxisPace;
use stepwright_serve::path::{FILE, PathDrawing, PathFile, PathListener, PathReader, PathTable};

use crate::cycle;
use crate::cycle::voice::Aloud;
use crate::failure::Failure;
use crate::gcode;
use crate::gcode::axes::AxesArgs;
use crate::interrupt;
use crate::machine::{MachineArgs, MachineAxes};
use crate::order::target::{PortArgs, RATE};
use stepwright_play::page::{PageJob, draw_cycles, play_cycles, play_cycles_on};
use stepwright_play::stream::{PlayEnd, PlayOrder, PlayWish};

/// The examples, from the folders `examples/cycles` and `examples/gcode`.
const EXAMPLES: [(&str, &str); 9] = [
    ("drawing.toml", include_str!("paths/drawing.toml")),
    ("joined.toml", include_str!("paths/joined.toml")),
    ("feed.toml", include_str!("paths/feed.toml")),
    ("triangle.toml", include_str!("paths/triangle.toml")),
    ("series.toml", include_str!("paths/series.toml")),
    ("readme.toml", include_str!("paths/readme.toml")),
    ("calibrate.toml", include_str!("paths/calibrate.toml")),
    ("badge.nc", include_str!("paths/badge.nc")),
    ("engrave.nc", include_str!("paths/engrave.nc")),
];

/// The extensions of G-code jobs, in upper or lower case.
const JOBS: [&str; 6] = [".nc", ".ngc", ".gcode", ".gco", ".cnc", ".tap"];

/// The time between two looks at a run while the server ends.
const LOOK: Duration = Duration::from_millis(5);

/// The largest size of a cycle file, in bytes.
const CYCLES: usize = 200_000;

/// Reads files, and plays one at a time.
pub struct PathFiles {
    boards: PathBoards,
    /// The limits of a job's axes, by the machine file.
    axes: Result<[AxisPace; 3], Failure>,
    playing: Mutex<Option<Playing>>,
}

/// The ports of boards for running files; without a port a file runs on a virtual board.
#[derive(Clone, Debug, Default)]
pub struct PathBoards {
    /// The board that plays cycles.
    pub cycles: Option<PathBuf>,
    /// The board that plays streams, for jobs.
    pub stream: Option<PathBuf>,
}

/// A file that is being played, or was played.
struct Playing {
    kind: Kind,
    order: Arc<PlayOrder>,
    over: Arc<AtomicBool>,
    thread: JoinHandle<()>,
}

impl Playing {
    fn is_over(&self) -> bool {
        // A thread that panicked has not set `over`.
        self.over.load(Ordering::Relaxed) || self.thread.is_finished()
    }
}

/// The example for a laser, and its S of full power.
const ENGRAVED: (&str, f64) = ("engrave.nc", 1_000.0);

const VIRTUAL: &str = "On a virtual board of its own, in real time: the program of the served board \
                       takes travels, no paths. A stop brakes along the line or arc. A board with the \
                       program cycles plays it by the command, or here with `serve --cycles PORT`.";

const JOB: &str = "On a virtual board of its own, an Uno by its speed, in real time. Steps, speeds and \
                   accelerations are those of the machine file. A hold and a stop brake along the path. \
                   A board with the program stream runs jobs with `serve --stream PORT`.";

/// The kind of a file.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Cycles,
    Job,
}

impl Kind {
    fn of(file: &PathFile) -> Kind {
        let name = file.name.to_ascii_lowercase();
        match JOBS.iter().any(|ending| name.ends_with(ending)) {
            true => Kind::Job,
            false => Kind::Cycles,
        }
    }
}

impl PathFiles {
    /// Runs files on these boards, and jobs with the axes of this machine. An error in the machine
    /// file is reported for jobs only.
    pub fn on(boards: PathBoards, machine: &MachineArgs) -> PathFiles {
        let axes = MachineAxes::quiet(machine).and_then(|file| AxesArgs::default().of(&file));
        PathFiles { boards, axes, playing: Mutex::default() }
    }

    /// Brakes the running file and waits for its end, because the server ends; a second Ctrl-C kills it.
    pub fn finish(&self) {
        self.stop();
        let Some(playing) = self.playing().take() else { return };
        // By a panic, too.
        while !playing.thread.is_finished() {
            if interrupt::presses() >= 2 {
                playing.order.kill();
            }
            thread::sleep(LOOK);
        }
    }

    fn axes(&self) -> Result<[AxisPace; 3], Declined> {
        self.axes.as_ref().copied().map_err(|failure| {
            let declined = Declined::range(format!("the machine file: {}", failure.message()));
            declined.remedy("mend the machine file, and start `stepwright serve` again")
        })
    }

    fn playing(&self) -> MutexGuard<'_, Option<Playing>> {
        // No change of the value can be left half done by a panic.
        self.playing.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl PathReader for PathFiles {
    fn table(&self) -> PathTable {
        let file = |(name, text): (&str, &str)| PathFile {
            name: name.into(),
            text: text.into(),
            laser: (name == ENGRAVED.0).then_some(ENGRAVED.1),
        };
        let name = |port: &PathBuf| port.display().to_string();
        let port = self.boards.cycles.as_ref().map(name);
        let job_port = self.boards.stream.as_ref().map(name);
        let jobs = match &job_port {
            None => JOB.to_owned(),
            Some(port) => format!(
                "On the board at {port}, streamed. Steps, speeds and accelerations are those of the \
                 machine file. The place where the board stands is the job's zero. A hold and a stop brake \
                 along the path; a board that hears nothing more brakes by itself."
            ),
        };
        let player = match &port {
            None => VIRTUAL.to_owned(),
            Some(port) => format!(
                "On the board at {port}, which says some ten times a second where its motors are. A \
                 stop ends the cycle there at once, without a ramp."
            ),
        };
        let board = port.clone().unwrap_or_else(|| "a virtual board".to_owned());
        PathTable {
            port,
            board,
            player,
            jobs,
            job_board: job_port.clone().unwrap_or_else(|| "a virtual board".to_owned()),
            job_port,
            job_endings: JOBS.map(str::to_owned).into(),
            longest: FILE,
            examples: EXAMPLES.map(file).into(),
        }
    }

    fn draw(&self, file: &PathFile) -> Result<PathDrawing, Declined> {
        let drawn = match Kind::of(file) {
            Kind::Job => job(file, self.axes()?).draw(),
            Kind::Cycles if file.laser.is_some() => {
                return Err(Declined::range(format!("{} is no job: it has no laser", file.name)));
            }
            Kind::Cycles if file.text.len() > CYCLES => {
                let long = format!("{} is too long for a cycle file", file.name);
                let jobs = format!("the name of a G-code job ends in {}", JOBS.join(", "));
                return Err(Declined::range(long)
                    .allowed(format!("at most {CYCLES} bytes"))
                    .remedy(jobs));
            }
            Kind::Cycles => draw_cycles(&file.name, &file.text, &Aloud),
        };
        let drawn = drawn.map_err(|error| declined(&error.into(), file))?;
        Ok(PathDrawing { id: file.id(), ..drawn })
    }

    fn run(
        &self,
        file: &PathFile,
        drawing: &PathDrawing,
        tell: PathListener,
    ) -> Result<(), Declined> {
        let mut playing = self.playing();
        if playing.as_ref().is_some_and(|one| !one.is_over()) {
            return Err(Declined::refused("a file is being run")
                .remedy("let it end, or stop it: POST /api/stop"));
        }
        if let Some(refused) = &drawing.refused {
            return Err(Declined::range(format!("{}: {refused}", file.name))
                .remedy("a lower top-speed of this axis in the machine file"));
        }
        let (order, over) = (Arc::new(PlayOrder::default()), Arc::new(AtomicBool::new(false)));
        let kind = Kind::of(file);
        let first = |places: &Vec<f64>| places.first().map_or(0, |place| place.round() as i64);
        let last = PathReport {
            name: file.name.clone(),
            id: file.id(),
            state: "running",
            places: drawing.places.iter().map(first).collect(),
            ..PathReport::default()
        };
        // Whoever receives this report finds the new run, not the one before.
        tell(last.clone());
        let thread = thread::spawn({
            let (file, order, over) = (file.clone(), order.clone(), over.clone());
            let player = match (kind, &self.boards) {
                (Kind::Job, PathBoards { stream: None, .. }) => Player::Job(self.axes()?),
                (Kind::Job, PathBoards { stream: Some(port), .. }) => {
                    Player::Stream(self.axes()?, port.clone())
                }
                (Kind::Cycles, PathBoards { cycles: None, .. }) => Player::Virtual,
                (Kind::Cycles, PathBoards { cycles: Some(port), .. }) => {
                    Player::Board(port.clone())
                }
            };
            move || play(&file, player, last, (&order, &over), &tell)
        });
        *playing = Some(Playing { kind, order, over, thread });
        Ok(())
    }

    fn stop(&self) {
        if let Some(playing) = &*self.playing() {
            playing.order.stop();
        }
    }

    fn hold(&self, held: bool) -> Result<(), Declined> {
        match &*self.playing() {
            Some(playing) if !playing.is_over() => match playing.kind {
                Kind::Job => {
                    playing.order.hold(held);
                    Ok(())
                }
                Kind::Cycles => Err(Declined::refused("a cycle file can't be held")
                    .remedy("stop it: POST /api/stop")),
            },
            _ => Err(Declined::refused("no file is being run")),
        }
    }

    fn kill(&self) {
        if let Some(playing) = &*self.playing() {
            playing.order.kill();
        }
    }
}

/// The job of a file.
fn job(file: &PathFile, axes: [AxisPace; 3]) -> PageJob<'_> {
    PageJob { name: &file.name, text: &file.text, axes, laser: file.laser }
}

/// The player of a file.
enum Player {
    Virtual,
    Board(PathBuf),
    Job([AxisPace; 3]),
    Stream([AxisPace; 3], PathBuf),
}

/// Plays a file, and reports the progress.
fn play(
    file: &PathFile,
    player: Player,
    mut last: PathReport,
    (order, over): (&PlayOrder, &AtomicBool),
    tell: &PathListener,
) {
    let mut hear = |seconds: f64, places: &[i64], wish: PlayWish| {
        // If the server ends, the run brakes, and by a second Ctrl-C it stops.
        match (interrupt::presses(), interrupt::asked()) {
            (2.., _) => order.kill(),
            (_, true) => order.stop(),
            _ => {}
        }
        let state = match wish {
            PlayWish::Go => "running",
            PlayWish::Hold => "held",
            PlayWish::Brake | PlayWish::Kill => "braking",
        };
        last = PathReport { state, seconds, places: places.to_vec(), ..last.clone() };
        tell(last.clone());
    };
    let played = match player {
        Player::Virtual => {
            play_cycles(&file.name, &file.text, order, &mut hear).map_err(Failure::from)
        }
        Player::Board(port) => cycle::meet(&port, RATE)
            .and_then(|board| Ok(play_cycles_on(board, &file.name, &file.text, order, &mut hear)?)),
        Player::Job(axes) => job(file, axes).play(order, &mut hear).map_err(Failure::from),
        Player::Stream(axes, port) => gcode::port::meet(&PortArgs::at(port), "serve")
            .and_then(|mut board| Ok(job(file, axes).play_on(&mut board, order, &mut hear)?)),
    };
    let (state, trouble) = match &played {
        Ok(PlayEnd::Done) => ("done", None),
        Ok(PlayEnd::Stopped) => ("stopped", None),
        Ok(PlayEnd::Killed) => ("killed", None),
        Err(failure) => {
            let Declined { what, remedy, .. } = declined(failure, file);
            ("failed", Some(Trouble { what, remedy }))
        }
    };
    // Set before the report: whoever receives the end may begin the next run.
    over.store(true, Ordering::Relaxed);
    tell(PathReport { state, trouble, ..last });
}

/// The refusal for an error of a file, in one line.
fn declined(failure: &Failure, file: &PathFile) -> Declined {
    let name = &file.name;
    // The message of a job has its own position, and the error's number.
    let placed = failure.message().strip_prefix(&format!("{name}: line "));
    let declined = Declined::range(match (placed, failure.place()) {
        (Some(rest), _) => format!("{name}, line {rest}"),
        (None, Some(place)) => format!("{name}, line {}: {}", place.line, place.what),
        (None, None) => failure.message().to_owned(),
    });
    match failure.hinted() {
        Some(hint) => declined.remedy(hint),
        None => declined,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};
    use std::path::Path;

    /// Without a machine file.
    fn files() -> PathFiles {
        let axes = AxesArgs::default().of(&MachineAxes::none());
        PathFiles { boards: PathBoards::default(), axes, playing: Mutex::default() }
    }

    #[test]
    fn examples_are_those_of_the_folder() {
        let mut count = 0;
        for kind in ["cycles", "gcode"] {
            let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples").join(kind);
            for entry in std::fs::read_dir(&folder).unwrap() {
                let name = entry.unwrap().file_name().into_string().unwrap();
                let own = std::fs::read_to_string(folder.join(&name)).unwrap();
                let carried = EXAMPLES.iter().find(|(known, _)| *known == name);
                assert!(
                    carried.is_some_and(|(_, text)| *text == own),
                    "copy it: cp examples/{kind}/{name} crates/stepwright-cli/src/serve/paths"
                );
                count += 1;
            }
        }
        assert_eq!(count, EXAMPLES.len());
    }

    /// A `drawing` rounded for the page: positions to a µm, speeds to a µm/s, times to 10 µs.
    fn carried(mut drawing: Value) -> Value {
        fn round(value: &mut Value, by: &dyn Fn(f64) -> Value) {
            match value {
                Value::Array(all) => all.iter_mut().for_each(|one| round(one, by)),
                Value::Number(one) => *value = by(one.as_f64().unwrap()),
                _ => {}
            }
        }
        for nm in ["places", "speeds"] {
            round(&mut drawing[nm], &|nm| json!((nm / 1e3).round() as i64 * 1000));
        }
        round(&mut drawing["times"], &|s| json!((s * 1e5).round() / 1e5));
        drawing
    }

    /// The drawings of a page without a server. `STEPWRIGHT_GOLDEN=write` writes them.
    #[test]
    fn drawings_that_the_page_carries_are_those_of_today() {
        let path =
            concat!(env!("CARGO_MANIFEST_DIR"), "/../stepwright-serve/src/page/alone/paths.json");
        let files = files();
        let drawn = files.table().examples.into_iter().map(|file| {
            let drawing = serde_json::to_value(files.draw(&file).unwrap()).unwrap();
            json!({ "file": file, "drawing": drawing })
        });
        let drawn: Vec<Value> = drawn.collect();
        if std::env::var_os("STEPWRIGHT_GOLDEN").is_some_and(|what| what == "write") {
            let lines: Vec<_> = drawn
                .iter()
                .map(|one| {
                    let drawing = carried(one["drawing"].clone());
                    json!({ "file": one["file"], "drawing": drawing }).to_string()
                })
                .collect();
            std::fs::write(path, format!("[\n{}\n]\n", lines.join(",\n"))).unwrap();
        }
        let carried: Vec<Value> =
            serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
        assert_eq!(carried.len(), drawn.len());
        // On another computer, the sine may move a point by a µs.
        let near = |a: &Value, b: &Value| {
            let (a, b) = (a.as_f64().unwrap(), b.as_f64().unwrap());
            (a - b).abs() <= 2e-6 + 1e-5 * a.abs()
        };
        for (carried, drawn) in carried.iter().zip(&drawn) {
            assert_eq!(carried["file"], drawn["file"], "write it again");
            let (carried, drawn) = (&carried["drawing"], &drawn["drawing"]);
            for exact in ["unit", "motors"] {
                assert_eq!(carried[exact], drawn[exact], "write it again");
            }
            assert!(near(&carried["seconds"], &drawn["seconds"]), "write it again");
            let legs = |of: &Value| of["legs"].as_array().unwrap().clone();
            assert_eq!(legs(carried).len(), legs(drawn).len());
            for (carried, drawn) in legs(carried).iter().zip(legs(drawn)) {
                assert_eq!((&carried["kind"], &carried["line"]), (&drawn["kind"], &drawn["line"]));
                for one in ["begin", "end", "peak"] {
                    assert!(near(&carried[one], &drawn[one]), "{one}: {carried} {drawn}");
                }
            }
        }
    }

    #[test]
    fn a_laser_is_of_a_job_alone() {
        let cycles = PathFile { laser: Some(1_000.0), ..files().table().examples[0].clone() };
        let declined = files().draw(&cycles).unwrap_err();
        assert_eq!(declined.what, "drawing.toml is no job: it has no laser");
        let job = PathFile {
            name: "a.nc".into(),
            text: "M4 S100 G1 F600 X1".into(),
            laser: Some(1_000.0),
        };
        let spindle = PathFile { laser: None, ..job.clone() };
        assert_ne!(job.id(), spindle.id());
        assert_eq!(files().draw(&job).unwrap().refused, None);
    }

    #[test]
    fn a_mistake_is_told_with_its_line() {
        let (name, text) = ("a.toml".into(), "[[motor]]\nname = 1\n".into());
        let file = PathFile { name, text, laser: None };
        let declined = files().draw(&file).unwrap_err();
        assert_eq!(declined.status(), 422);
        assert!(declined.what.starts_with("a.toml, line 2: invalid type"), "{declined:?}");
    }
}
