//! `verify`: checks every file of a run, from its pieces to its surface, and writes again what can be.

use std::ffi::{OsStr, OsString};

use indicatif::HumanCount;
use serde_json::json;

use super::completion::lost_tiles;
use super::limit::check_limits;
use crate::cli::VerifyArguments;
use crate::evaluate::maps::Maps;
use crate::evaluate::parts::Parts;
use crate::failure::{Advice, Failure};
use crate::files::folder::Folder;
use crate::job::{Job, MapUse};
use crate::messages::{Code, Place};
use crate::output::{counted, quoted, result, warn, warn_of};
use crate::store::digests::{DIGESTS, Digests, Fit, Known, digest_of_file};
use crate::store::directory::RunDirectory;
use crate::store::file_state::{FileState, state_of};
use crate::store::frozen_job::keep_asked;
use crate::store::layout::{AUDITS, JOB, LIMITS, MAPS, RECORD, SEARCHES, SHARDS, SURFACE, WITH_DIGESTS};
use crate::store::lock::Access;
use crate::store::map_pieces;
use crate::store::outdated::{outdated, renewal};
use crate::store::piece::{Defect, is_piece_name, read_checked};
use crate::store::provenance::is_record;
use crate::store::tally::Tally;
use crate::tables::surface::Surface;

/// `stickslip verify`.
pub fn verify(arguments: &VerifyArguments) -> Result<(), Failure> {
    let (directory, can_repair) = match RunDirectory::open_any(&arguments.run, Access::Alone) {
        // An archived run can be checked, too.
        Err(failure) if failure.is_of_creating() => (RunDirectory::open_any(&arguments.run, Access::Reading)?, false),
        opened => (opened?, true),
    };
    let mut check = Check { directory: &directory, can_repair, findings: Vec::new(), refused: None };
    let advice = check.all()?;
    let Check { findings, refused, .. } = check;
    // A picture of earlier results says nothing against the run.
    let outdated: Vec<&str> =
        findings.iter().filter(|finding| finding.state == State::Outdated).map(|finding| &*finding.file).collect();
    let of_run = findings.iter().map(|finding| finding.state).filter(|state| *state != State::Outdated);
    let worst = of_run.max().unwrap_or(State::Sound);
    let run = arguments.run.display();
    result(&if arguments.json {
        let files = findings
            .iter()
            .map(|finding| json!({ "file": finding.file, "state": finding.state.name(), "remark": finding.remark }));
        let said = json!({
            "run": run.to_string(),
            "state": worst.name(),
            "outdated": outdated,
            "files": files.collect::<Vec<_>>(),
        });
        format!("{said:#}\n")
    } else {
        let lines = findings.iter().map(|finding| {
            let Finding { file, remark, .. } = finding;
            format!("{file}: {remark}\n")
        });
        lines.collect()
    })?;
    let broken: Vec<&str> =
        findings.iter().filter(|finding| finding.state == State::Broken).map(|finding| &*finding.file).collect();
    if broken.is_empty() {
        return refused.map_or(Ok(()), Err);
    }
    let text = format!("{run}: damaged: {}", broken.join(", "));
    Err(Failure::InputOutput(text).coded(Code::Damaged).at(Place::file(&arguments.run)).with_advice(&advice))
}

/// How a file was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum State {
    /// As it was written, or rightly not there yet.
    Sound,
    /// A report or picture of other results than those of the run.
    Outdated,
    /// Damaged or lost, and written again.
    Repaired,
    /// Damaged or lost.
    Broken,
}

impl State {
    fn name(self) -> &'static str {
        match self {
            Self::Sound => "sound",
            Self::Outdated => "outdated",
            // Programs read this name.
            Self::Repaired => "mended",
            Self::Broken => "broken",
        }
    }
}

/// What was found of a file.
struct Finding {
    file: String,
    state: State,
    remark: String,
}

/// A check in progress.
struct Check<'a> {
    directory: &'a RunDirectory,
    can_repair: bool,
    findings: Vec<Finding>,
    /// Why a job that is as it was written is refused, so that not all could be checked.
    refused: Option<Failure>,
}

impl Check<'_> {
    fn find(&mut self, file: &str, state: State, remark: impl Into<String>) {
        self.findings.push(Finding { file: file.to_owned(), state, remark: remark.into() });
    }

    /// What was damaged and is written again, if anything can be written.
    fn repaired(&self) -> State {
        if self.can_repair { State::Repaired } else { State::Broken }
    }

    /// Checks everything; returns what to do about what stays damaged.
    fn all(&mut self) -> Result<Advice, Failure> {
        let directory = self.directory;
        if self.can_repair {
            directory.tidy()?;
        }
        let known = Known::read(directory.root())?;
        match &known {
            Known::Digests(_) if self.are_of_another_run(&known) => self.forget_digests("of another run")?,
            Known::Digests(_) => self.find(DIGESTS, State::Sound, "sound"),
            Known::Nothing => self.find(DIGESTS, State::Sound, "none; it was removed"),
            Known::Damaged => self.forget_digests("damaged")?,
        }
        let run = quoted(directory.path());
        let Some((text, job)) = self.job()? else {
            if self.refused.is_some() {
                self.all_pieces()?;
                self.results_without_job()?;
                self.record();
            }
            let again = format!("submit the job again to this directory with `--out {run}`; finished pieces are kept");
            return Ok(Advice::action(&again));
        };
        if job.model.unread().is_some()
            && let Err(refused) = directory.job()
        {
            warn([refused.to_string()]);
        }
        self.all_pieces()?;
        self.surface(&job)?;
        self.lost(&job)?;
        self.limits(&job)?;
        for name in outdated(directory) {
            let again = renewal(&name, directory.path());
            self.find(
                &name,
                State::Outdated,
                format!("outdated, it shows earlier results of the run; make it again, for example with `{again}`"),
            );
        }
        self.record();
        if self.can_repair {
            self.write_digests(&text, &job)?;
        }
        let lacks_tables = self.findings.iter().any(|finding| finding.file == JOB && finding.state == State::Broken);
        Ok(match self.can_repair {
            true if lacks_tables => {
                let job = quoted(&directory.path().join(JOB));
                Advice::action(&format!(
                    "for its tables, remove {job} and submit the job again with `--out {run}`; finished pieces are kept"
                ))
            }
            true => Advice::command("compute what is lost again with", &format!("stickslip resume {run}")),
            false => Advice::action("nothing can be written in this directory; verify a copy of it"),
        })
    }

    /// Writes digests of nothing in place of those that tell nothing of the files beside them.
    fn forget_digests(&mut self, what: &str) -> Result<(), Failure> {
        let again = if self.can_repair { ", and written again" } else { "" };
        let remark = format!("{what}{again}; the other files were checked without it");
        self.find(DIGESTS, self.repaired(), remark);
        if self.can_repair { self.directory.publish_digests(&Digests::default()) } else { Ok(()) }
    }

    /// Whether the digests are those of other files than the ones that lie beside them: of several that are there, none
    /// fits. Damage to all of them at once is no likelier than a file that was copied to the wrong place.
    fn are_of_another_run(&self, known: &Known) -> bool {
        let root = self.directory.root();
        let fit = |name: &&str| {
            let digest = root.open_file(name).and_then(digest_of_file).ok()?;
            Some(known.fit(name, &digest)).filter(|fit| *fit != Fit::Unknown)
        };
        let fits: Vec<Fit> = WITH_DIGESTS.iter().filter_map(fit).collect();
        fits.len() > 1 && fits.iter().all(|fit| *fit == Fit::Differs)
    }

    /// The frozen job and its text, written again from the surface if it is damaged or lost.
    fn job(&mut self) -> Result<Option<(String, Job)>, Failure> {
        let directory = self.directory;
        let why = match directory.job_source() {
            Ok(Some(source)) => match source.job_to_read() {
                Ok(job) => {
                    match &directory.lost_tables(&source.text, &job)?[..] {
                        [] => self.find(JOB, State::Sound, "sound"),
                        lost => self.find(
                            JOB,
                            State::Broken,
                            format!("it was written again without {}", lost.join(" and ")),
                        ),
                    }
                    return Ok(Some((source.text, job)));
                }
                Err(refused) => {
                    self.refused = directory.refused_as_written(&source, &refused);
                    if self.refused.is_some() {
                        self.find(JOB, State::Sound, "sound, but refused; results are not compared with pieces");
                        return Ok(None);
                    }
                    "damaged"
                }
            },
            Ok(None) => "lost",
            Err(_) => "damaged",
        };
        let Some((source, job)) = directory.job_of_surface() else {
            self.find(
                JOB,
                State::Broken,
                format!("{why}, and there is no sound surface of this job to write it again from"),
            );
            return Ok(None);
        };
        let lacking = directory.lacking_tables(&source.text, &job)?;
        let has_lost = !lacking.is_empty();
        if self.can_repair {
            if has_lost && directory.root().open_file(JOB).is_ok() {
                directory.set_aside(directory.root(), JOB.as_ref(), "its tables may still be read in it");
            }
            directory.publish(JOB, source.text.as_bytes())?;
        }
        let but = if has_lost { format!(", but for {}", lacking.join(" and ")) } else { String::new() };
        let again = if self.can_repair { ", and it is written again" } else { "" };
        let state = if has_lost { State::Broken } else { self.repaired() };
        self.find(JOB, state, format!("{why}; the surface holds what it was{but}{again}"));
        Ok(Some((source.text, job)))
    }

    /// The pieces in all folders.
    fn all_pieces(&mut self) -> Result<(), Failure> {
        let directory = self.directory;
        self.pieces(SHARDS, directory.shards());
        let folders = [(MAPS, directory.maps()?), (AUDITS, directory.audits()?), (SEARCHES, directory.searches()?)];
        for (name, folder) in folders {
            folder.iter().for_each(|folder| self.pieces(name, folder));
        }
        Ok(())
    }

    /// The results of a job that is refused: whether they are as they were written.
    fn results_without_job(&mut self) -> Result<(), Failure> {
        for name in [SURFACE, LIMITS] {
            match state_of(self.directory.root(), name, &[])? {
                FileState::Absent => {}
                FileState::Damaged(why) => self.find(name, State::Broken, format!("damaged ({why})")),
                FileState::Sound | FileState::OfAnotherJob | FileState::OfAnotherVersion => {
                    self.find(name, State::Sound, "as it was written");
                }
            }
        }
        Ok(())
    }

    /// The pieces in a folder: each must have the content that its name says.
    fn pieces(&mut self, name: &str, folder: &Folder) {
        let names: Vec<OsString> = match folder.names() {
            Ok(names) => names.into_iter().filter(|name| is_piece_name(name)).collect(),
            Err(error) => return self.find(name, State::Broken, error.to_string()),
        };
        let damaged: Vec<(&OsStr, Defect)> =
            names.iter().filter_map(|name| Some((&**name, read_checked(folder, name).err()?))).collect();
        for (name, defect) in &damaged {
            match defect {
                Defect::Damaged(why) if self.can_repair => self.directory.set_aside(folder, name, why),
                Defect::Damaged(why) | Defect::Unread(why) => {
                    warn_of(&folder.path().join(name), format_args!(": {why}"));
                }
            }
        }
        let count = counted(names.len() as u128, "piece", "pieces");
        let name = format!("{name}/");
        match damaged.len() {
            0 => self.find(&name, State::Sound, format!("{count}, all sound")),
            damaged => {
                self.find(&name, State::Broken, format!("{count}, {} of them damaged", HumanCount(damaged as u64)));
            }
        }
    }

    /// What a run with all its samples, or with its integrals, has lost of its verdict map and of its audits.
    fn lost(&mut self, job: &Job) -> Result<(), Failure> {
        let directory = self.directory;
        let (mut tiles, mut needed) = lost_tiles(directory, job, &directory.tally(job)?)?;
        if job.map_use() == MapUse::Integrate && directory.has_surface_of(job)? {
            let mut maps = Maps::new(job);
            directory.maps()?.map(|folder| map_pieces::load(&mut maps, &folder)).transpose()?;
            (tiles, needed) = (maps.missing().len(), maps.needed());
        }
        let audits = Parts::of_audits(job);
        if audits.all_units() > 0 && directory.has_surface_of(job)? && !are_audited(job, &directory.audits_done(job)?) {
            self.add(AUDITS, "some of the audited samples are lost");
        }
        if tiles > 0 {
            let [tiles, needed] = [tiles, needed].map(|tiles| HumanCount(tiles as u64));
            self.add(MAPS, &format!("{tiles} of the {needed} tiles of the verdict map are lost"));
        }
        Ok(())
    }

    /// Adds to what was found of a folder that something of it is lost.
    fn add(&mut self, folder: &str, remark: &str) {
        let file = format!("{folder}/");
        match self.findings.iter_mut().find(|finding| finding.file == file) {
            Some(finding) => {
                finding.state = State::Broken;
                finding.remark += &format!("; {remark}");
            }
            None => self.find(&file, State::Broken, remark),
        }
    }

    /// The surface: as it was written, and the one that the pieces give.
    fn surface(&mut self, job: &Job) -> Result<(), Failure> {
        let directory = self.directory;
        let state = directory.surface_state(job)?;
        let tally = directory.tally(job)?;
        let complete = Parts::new(job).complete_cells(&tally);
        let audits = (job.plain_samples() > 0).then(|| directory.audits_done(job)).transpose()?;
        let are_audited = audits.as_ref().is_none_or(|audits| are_audited(job, audits));
        if complete == job.cells() && are_audited {
            let surface = Surface::new(job, &tally).audited(audits.as_ref());
            if surface.is_published(directory)? {
                self.find(SURFACE, State::Sound, "sound, the same bytes as the pieces give");
                return Ok(());
            }
            if self.can_repair {
                surface.publish(directory)?;
            }
            let was = match state {
                FileState::Absent => "not written yet".to_owned(),
                FileState::OfAnotherJob => "that of the run before it was extended".to_owned(),
                FileState::OfAnotherVersion => "that of another version of stickslip".to_owned(),
                FileState::Damaged(why) => format!("damaged ({why})"),
                FileState::Sound => "not the one that the pieces give".to_owned(),
            };
            let remark = if self.can_repair { "; it is written again from the pieces" } else { "" };
            self.find(SURFACE, self.repaired(), format!("{was}{remark}"));
            return Ok(());
        }
        let lacks = if are_audited { "" } else { ", and plain samples are missing" };
        let progress = format!("{} of {} cells are complete{lacks}", HumanCount(complete), HumanCount(job.cells()));
        match state {
            FileState::Sound if !job.draws_samples() => self.find(SURFACE, State::Sound, "sound"),
            FileState::Sound => {
                self.find(SURFACE, State::Broken, format!("as it was written, but of its pieces only {progress}"));
            }
            FileState::Absent | FileState::OfAnotherJob | FileState::OfAnotherVersion => {
                let remark =
                    if job.draws_samples() { format!("none yet: {progress}") } else { "not written yet".to_owned() };
                self.find(SURFACE, State::Sound, remark);
            }
            FileState::Damaged(why) => {
                if self.can_repair {
                    directory.set_aside(directory.root(), SURFACE.as_ref(), &why);
                }
                self.find(SURFACE, State::Broken, format!("damaged ({why})"));
            }
        }
        Ok(())
    }

    /// The limits that the job asks for. They take a search, which is left to `resume`.
    fn limits(&mut self, job: &Job) -> Result<(), Failure> {
        let directory = self.directory;
        let Some(state) = check_limits(directory, job)? else { return Ok(()) };
        match state {
            FileState::Sound => self.find(LIMITS, State::Sound, "sound"),
            FileState::Absent => self.find(LIMITS, State::Sound, "not written yet"),
            FileState::OfAnotherJob | FileState::OfAnotherVersion => {
                self.find(LIMITS, State::Sound, "those of the run before its job was changed");
            }
            FileState::Damaged(why) => {
                if self.can_repair {
                    directory.set_aside(directory.root(), LIMITS.as_ref(), &why);
                }
                self.find(LIMITS, State::Broken, format!("damaged ({why})"));
            }
        }
        Ok(())
    }

    /// The record of sessions.
    fn record(&mut self) {
        let directory = self.directory;
        let read = directory.read_known(RECORD).map(|bytes| bytes.map(|bytes| is_record(&bytes)));
        let why = match read {
            Ok(None) => return self.find(RECORD, State::Sound, "none"),
            Ok(Some(true)) => return self.find(RECORD, State::Sound, "sound"),
            Ok(Some(false)) => "it is not a record of sessions".to_owned(),
            Err(why) => why,
        };
        if self.can_repair {
            directory.set_aside(directory.root(), RECORD.as_ref(), &why);
        }
        self.find(RECORD, self.repaired(), format!("damaged ({why}); nothing depends on it"));
    }

    /// Writes the digests of what is there now.
    fn write_digests(&self, text: &str, job: &Job) -> Result<(), Failure> {
        let root = self.directory.root();
        let mut digests = Digests::default();
        keep_asked(&mut digests, &Known::read(root)?.into_digests(), text, job);
        for name in WITH_DIGESTS {
            let file = root.open_if_there(name).map_err(|error| Failure::reading(&root.path().join(name), error))?;
            let digest = file.map(digest_of_file).transpose();
            digests.set(name, digest.map_err(|error| Failure::reading(&root.path().join(name), error))?);
        }
        self.directory.publish_digests(&digests)
    }
}

/// Whether the audits of a job, or its plain samples, are all there: at least those that there are however long one takes.
fn are_audited(job: &Job, audits: &Tally) -> bool {
    match job.model.unread() {
        None => Parts::of_audits(job).are_complete(audits),
        Some(_) => (0..job.cells()).all(|cell| audits.is_complete(cell, job.certain_plain_samples())),
    }
}
