//! Pins the threads of CPU implementations to cores.

/// Environment variables for the thread counts of PoCL (several versions) and of rayon.
const THREADS: [&str; 3] = ["POCL_MAX_PTHREAD_COUNT", "POCL_CPU_MAX_CU_COUNT", "RAYON_NUM_THREADS"];

/// Number of MPI processes on this machine, if more than one.
fn local_processes() -> Option<usize> {
    let value = ["OMPI_COMM_WORLD_LOCAL_SIZE", "MPI_LOCALNRANKS"].iter().find_map(|name| std::env::var(name).ok());
    value?.parse().ok().filter(|&processes| processes > 1)
}

/// Number of cores available to the parent process.
fn cores_of_parent() -> Option<usize> {
    #[cfg(not(unix))]
    return None;
    #[cfg(unix)]
    {
        let parent = std::os::unix::process::parent_id();
        let status = std::fs::read_to_string(format!("/proc/{parent}/status")).ok()?;
        count_cpus(status.lines().find_map(|line| line.strip_prefix("Cpus_allowed_list:"))?)
    }
}

/// Number of CPUs in a list such as `0-3,8`.
fn count_cpus(list: &str) -> Option<usize> {
    let range = |part: &str| {
        let (first, last) = part.split_once('-').unwrap_or((part, part));
        Some(last.trim().parse::<usize>().ok()?.checked_sub(first.trim().parse().ok()?)? + 1)
    };
    list.trim().split(',').map(range).sum()
}

/// Whether the environment asks for more threads than there are cores. PoCL aborts if it has to pin them.
fn more_threads_than(cores: usize) -> bool {
    let asked = |name: &&str| std::env::var(name).ok()?.parse::<usize>().ok();
    THREADS.iter().filter_map(asked).any(|threads| threads > cores)
}

/// Makes PoCL pin its threads to cores. Does nothing if `POCL_AFFINITY` is set, if this process may not use every core, or if the
/// environment asks for more threads than cores.
///
/// Without pinning, Linux often runs both threads of a two-core machine on the same core and does not move them within frames of
/// a millisecond: fuel takes 1.40 ms instead of 0.91 (`layersplat bench` with `POCL_AFFINITY` 0 and 1).
///
/// If MPI started several processes on this machine, each gets an equal share of the cores instead, unless the environment sets
/// thread counts: if every rank used all cores, ranks would wait for each other's threads.
///
/// # Safety
/// Changes the environment: no other thread may run.
pub unsafe fn pin_cpu_threads() {
    if let Some(processes) = local_processes() {
        // MPI may have bound this process to its share already. The parent process has the cores of all ranks.
        let own = std::thread::available_parallelism().map_or(1, |cores| cores.get());
        let all_cores = cores_of_parent().unwrap_or(own).max(own);
        let share = (all_cores / processes).clamp(1, own).to_string();
        for name in THREADS.iter().filter(|name| std::env::var_os(name).is_none()) {
            // SAFETY: guaranteed by the caller.
            unsafe { std::env::set_var(name, &share) };
        }
        return;
    }
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let allowed = status.lines().find_map(|line| line.strip_prefix("Cpus_allowed_list:")).map(str::trim);
    let online = std::fs::read_to_string("/sys/devices/system/cpu/online").ok();
    let cores = std::thread::available_parallelism().map_or(1, |cores| cores.get());
    if more_threads_than(cores) {
        return;
    }
    if allowed.is_some() && allowed == online.as_deref().map(str::trim) && std::env::var_os("POCL_AFFINITY").is_none() {
        // SAFETY: guaranteed by the caller.
        unsafe { std::env::set_var("POCL_AFFINITY", "1") };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_of_cores() {
        assert_eq!([" 0-3,8", "5", "0-1"].map(count_cpus), [Some(5), Some(1), Some(2)]);
        assert_eq!(["", "a", "3-1"].map(count_cpus), [None; 3]);
    }
}
