//! Plays many stories on several threads and prints the results. Every kind of board uses this command.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use crate::{Fault, Rules, Story, Sum, shrink};

/// The options of a run.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct Run {
    /// How many stories.
    #[arg(long, value_name = "N", default_value_t = 10_000)]
    pub stories: u64,
    /// The first seed; a random one by default.
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Threads; by default one for each core.
    #[arg(long, value_name = "N")]
    pub jobs: Option<usize>,
    /// Play this story instead.
    #[arg(long, value_name = "FILE")]
    pub replay: Option<PathBuf>,
    /// Print the stories, and play none.
    #[arg(long)]
    pub print: bool,
    /// Rules to leave out, with commas between.
    #[arg(long = "without", value_name = "RULES", default_value = "", hide_default_value = true)]
    pub rules: Rules,
    /// Go on after a broken rule, up to this many.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub faults: usize,
}

/// The result of a run.
#[derive(Debug, Default)]
pub struct Outcome {
    /// The sum of all clean stories.
    pub sum: Sum,
    /// The seeds of stories that broke a rule, with the fault.
    pub faults: Vec<(u64, Fault)>,
}

/// The number of stories that a thread takes at a time.
const CHUNK: u64 = 16;

impl Run {
    /// Runs the command of these options. `make` makes the story of a seed, `play` plays it. Returns
    /// whether all stories were clean.
    ///
    /// # Errors
    /// A story file that can't be read.
    pub fn run(
        &self,
        make: impl Fn(u64) -> Story + Sync,
        play: impl Fn(&Story, Rules) -> Result<Sum, Fault> + Sync,
    ) -> Result<bool, String> {
        if let Some(path) = &self.replay {
            let text = std::fs::read_to_string(path);
            let text = text.map_err(|error| format!("{}: {error}", path.display()))?;
            let told = play(&text.parse()?, self.rules);
            match &told {
                Ok(sum) => println!("clean: {} lines, {} steps", sum.lines, sum.steps),
                Err(fault) => println!("{fault}"),
            }
            return Ok(told.is_ok());
        }
        let seed = self.seed.unwrap_or_else(|| fastrand::u64(..1 << 48));
        if self.print {
            for seed in seed..seed.saturating_add(self.stories) {
                println!("# seed {seed}\n{}", make(seed));
            }
            return Ok(true);
        }
        let begun = Instant::now();
        let Outcome { sum, faults } = self.all(seed, &make, &play);
        for (seed, fault) in &faults {
            println!("{}", tell(*seed, &make(*seed), fault, |story| play(story, self.rules)));
        }
        println!("{}", report(sum, begun.elapsed(), faults.len()));
        Ok(faults.is_empty())
    }

    /// Plays all stories.
    pub fn all(
        &self,
        seed: u64,
        make: &(impl Fn(u64) -> Story + Sync),
        play: &(impl Fn(&Story, Rules) -> Result<Sum, Fault> + Sync),
    ) -> Outcome {
        let cores = || std::thread::available_parallelism().map_or(1, usize::from);
        let jobs = self.jobs.unwrap_or_else(cores);
        println!("seed {seed}, {} stories, {jobs} jobs", self.stories);
        let bar = ProgressBar::new(self.stories);
        let style = "{bar:30} {human_pos} of {human_len} stories, {per_sec}, {eta} left";
        if let Ok(style) = ProgressStyle::with_template(style) {
            bar.set_style(style);
        }
        let (next, ended) = (AtomicU64::new(0), AtomicBool::new(false));
        let total = Mutex::new(Outcome::default());
        let work = || {
            loop {
                let first = next.fetch_add(CHUNK, Ordering::Relaxed);
                if first >= self.stories || ended.load(Ordering::Relaxed) {
                    return;
                }
                let last = (first + CHUNK).min(self.stories);
                for seed in (first..last).map(|n| seed.wrapping_add(n)) {
                    let told = play(&make(seed), self.rules);
                    let mut total = total.lock().unwrap_or_else(PoisonError::into_inner);
                    match told {
                        Ok(one) => total.sum = total.sum.plus(one),
                        Err(fault) => total.faults.push((seed, fault)),
                    }
                    ended.fetch_or(total.faults.len() >= self.faults, Ordering::Relaxed);
                }
                bar.inc(last - first);
            }
        };
        std::thread::scope(|scope| (0..jobs).for_each(|_| drop(scope.spawn(work))));
        bar.finish_and_clear();
        total.into_inner().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The shortened story that broke a rule, as a text for `--replay`.
pub fn tell(
    seed: u64,
    story: &Story,
    fault: &Fault,
    play: impl Fn(&Story) -> Result<Sum, Fault>,
) -> String {
    let (story, fault) = shrink::shrink(story, fault.clone(), |story| play(story).map(drop));
    format!("# seed {seed}: {fault}\n{story}")
}

fn report(sum: Sum, took: Duration, faults: usize) -> String {
    let Sum { stories, lines, steps, noise, micros } = sum;
    format!(
        "{stories} stories clean, {faults} not; {lines} lines, {noise} damaged bytes, \
         {steps} steps, {:.0} s of the boards' time in {:.0} s",
        micros as f64 / 1e6,
        took.as_secs_f64()
    )
}
