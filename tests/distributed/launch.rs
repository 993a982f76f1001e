//! Tests that run in several processes: a test starts its own program under `mpirun`, and each rank runs one case.

use layersplat::distributed::Group;
use layersplat::distributed::mpi::{self, Threading, environment::Universe};
use std::process::Command;

/// Name of the case for the ranks.
const CASE: &str = "LAYERSPLAT_TEST_CASE";

/// `mpirun` for tests: more ranks than cores, not bound to cores, as any user.
pub fn mpirun() -> Command {
    let mut command = Command::new("mpirun");
    command.args(["--oversubscribe", "--bind-to", "none"]);
    command.envs([("OMPI_ALLOW_RUN_AS_ROOT", "1"), ("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1")]);
    // One thread per rank, because there are more ranks than cores.
    command.envs([("POCL_MAX_PTHREAD_COUNT", "1"), ("RAYON_NUM_THREADS", "1")]);
    command
}

/// Runs a case on a number of ranks; all must succeed.
pub fn on_ranks(ranks: usize, case: &str) {
    let program = std::env::current_exe().expect("this program");
    let done = mpirun()
        .args(["-n", &ranks.to_string()])
        .arg(program)
        .args(["--exact", "as_a_rank", "--ignored", "--nocapture", "--quiet"])
        .env(CASE, case)
        .output()
        .expect("mpirun, of the package openmpi-bin, which scripts/mpi installs");
    let said = [done.stdout, done.stderr].map(|said| String::from_utf8_lossy(&said).into_owned()).concat();
    assert!(done.status.success(), "{case} on {ranks} ranks: {said}");
    // Ranks that do not find the case would succeed, too.
    assert_eq!(said.matches("ran the case").count(), ranks, "{case} on {ranks} ranks: {said}");
}

/// Runs a case as a rank. A failure of one rank ends all.
pub fn as_a_rank(run: impl FnOnce(&str, &Group)) {
    let case = std::env::var(CASE).expect("started by another test");
    let (universe, _): (Universe, Threading) = mpi::initialize_with_threading(Threading::Serialized).expect("MPI once");
    let group = Group::new(&universe.world()).expect("a group");
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        usual(panic);
        Group::abort(1);
    }));
    run(&case, &group);
    eprintln!("ran the case");
    group.wait();
    drop(std::panic::take_hook());
}
