#!/bin/sh
# Builds the guest's kernel with a clock of its own from Debian's sources (AX-562): kernel.sh FILE   FILE becomes a link to it.
# Kept in the user's cache, so that it is built once for each machine, source and kernel.config.  Never fails: without it the guest
# runs on Debian's own user-mode-linux, on the host's clock.
set -u
here=$(cd "$(dirname "$0")" && pwd)
link=$1

give_up() { echo "set-up: guest kernel: $1; the guest runs on Debian's user-mode-linux, on the host's clock" >&2; exit 0; }

source=$(ls /usr/src/linux-source-6.*.tar.xz 2>/dev/null | tail -n 1)
[ -n "$source" ] || give_up "no /usr/src/linux-source-6.*.tar.xz (Debian: apt-get install linux-source-6.1 flex bison bc xz-utils)"
cache=${XDG_CACHE_HOME:-${HOME:-/root}/.cache}/axisgate
key=$({ cat "$here/kernel.config"; ls -l "$source"; cc -dumpfullversion; } | cksum | cut -d ' ' -f 1)
kernel=$cache/guest-kernel-$key
mkdir -p "$cache" "$(dirname "$link")" || give_up "cannot write $cache"
exec 9>"$cache/lock"
flock 9  # several work trees of one machine: one builds, the others wait
if [ ! -x "$kernel" ]; then
    echo "set-up: building the guest's kernel from $source (some minutes, once)"
    work=$(mktemp -d "${TMPDIR:-/var/tmp}/axisgate-kernel.XXXXXX") || give_up "no temporary folder"
    job=
    clean() {
        [ -z "$job" ] || { kill -TERM "-$job" 2>/dev/null; wait "$job"; }
        rm -rf "$work" "$kernel.new"
    }
    trap clean EXIT
    for name in HUP INT TERM; do trap 'clean; trap - EXIT; exit 130' $name; done  # dash runs no EXIT trap when a signal ends it
    log=$cache/guest-kernel.log
    command -v setsid >/dev/null || give_up "setsid not found (Debian: apt-get install util-linux)"
    # A group of its own, and waited for: an interrupt is obeyed at once and ends all that builds.
    source=$source work=$work here=$here kernel=$kernel setsid sh -c '
        tar -xJf "$source" -C "$work" --strip-components=1 &&
            make -C "$work" ARCH=um KCONFIG_ALLCONFIG="$here/kernel.config" allnoconfig &&
            make -C "$work" ARCH=um -j"$(nproc)" linux &&
            cp "$work/linux" "$kernel.new" && mv "$kernel.new" "$kernel"
    ' >"$log" 2>&1 </dev/null 9>&- &
    job=$!
    wait "$job" || { job=; give_up "not built, see $log"; }
    job=
fi
ln -sfn "$kernel" "$link"
