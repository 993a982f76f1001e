//! Threads of CPU implementations, each on a core of its own.

/// Asks PoCL to pin its threads, unless `POCL_AFFINITY` says already whether to, or this process may not use every core.
///
/// Without, Linux often wakes both threads of a two-core machine on the same core, and leaves them there for frames of a
/// millisecond: fuel takes 1.40 ms instead of 0.91 (`layersplat bench` with `POCL_AFFINITY` 0 and 1).
///
/// # Safety
/// Changes the environment: no other thread may be running.
pub unsafe fn pin_cpu_threads() {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let allowed = status.lines().find_map(|line| line.strip_prefix("Cpus_allowed_list:")).map(str::trim);
    let online = std::fs::read_to_string("/sys/devices/system/cpu/online").ok();
    if allowed.is_some() && allowed == online.as_deref().map(str::trim) && std::env::var_os("POCL_AFFINITY").is_none() {
        // SAFETY: the caller's promise.
        unsafe { std::env::set_var("POCL_AFFINITY", "1") };
    }
}
