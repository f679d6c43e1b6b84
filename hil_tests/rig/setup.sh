#!/bin/sh
# What axisgate needs of the system beside Python packages; installs it as root on Debian, else says in one line what is missing.
#   setup.sh python PYTHON   a Python >= 3.11 with venv; exit 3 without it
#   setup.sh tools [PYTHON]  lanes vcan, mbpoll, cref, tshark, npm, the page in a browser and the benchmarks; never fails: a lane says what it lacks
set -u

install() {  # packages ...
    if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null && [ -f /etc/debian_version ]; then
        echo "set-up: installing $* (Debian packages)"
        log=$(mktemp)
        if apt-get update -q >"$log" 2>&1 && DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends "$@" >>"$log" 2>&1; then
            rm -f "$log"; return 0
        fi
        tail -n 5 "$log"; rm -f "$log"
    fi
    echo "set-up: missing: $* (Debian: apt-get install $*)"
    return 1
}

has() { PATH="$PATH:/usr/sbin:/sbin" command -v "$1" >/dev/null 2>&1; }

case ${1:-} in
python)
    python=${2:-python3}
    if ! "$python" -c 'import ensurepip, venv' 2>/dev/null; then
        install python3 python3-venv || exit 3
    fi
    "$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "set-up: Python 3.11 or newer needed; name one: make PYTHON=python3.11 ..."; exit 3; }
    ;;
tools)
    python=${2:-python3}
    missing=
    has linux.uml || missing="$missing user-mode-linux"
    has candump || missing="$missing can-utils"
    has ip || missing="$missing iproute2"
    has mbpoll || missing="$missing mbpoll"
    has tshark || missing="$missing tshark"
    has chromium || missing="$missing chromium"
    has mosquitto || missing="$missing mosquitto"
    has node || missing="$missing nodejs"
    has npm || missing="$missing npm"
    { has cc || has gcc; } || missing="$missing gcc"
    [ -f /usr/include/stdio.h ] || missing="$missing libc6-dev"
    [ -f "$("$python" -c 'import sysconfig; print(sysconfig.get_path("include"))')/Python.h" ] || missing="$missing python3-dev"  # gateway/cycle/native
    [ -f /usr/include/modbus/modbus.h ] || missing="$missing libmodbus-dev"
    [ -e build/guest-kernel ] || {  # what its build needs
        ls /usr/src/linux-source-6.*.tar.xz >/dev/null 2>&1 || missing="$missing linux-source-6.1"
        for tool in flex bison bc xz; do has $tool || missing="$missing $(echo $tool | sed 's/^xz$/xz-utils/')"; done
    }
    # shellcheck disable=SC2086 # a list of words
    [ -z "$missing" ] || install $missing || true
    if has npm && [ ! -d build/node/node_modules/modbus-serial ]; then
        echo "set-up: installing modbus-serial (npm) into build/node"
        mkdir -p build/node
        npm install --silent --no-audit --no-fund --omit=optional --prefix build/node modbus-serial@8 >build/node/install.log 2>&1 ||
            echo "set-up: npm could not fetch modbus-serial (build/node/install.log)"
    fi
    ;;
*)
    echo "usage: setup.sh python|tools" >&2; exit 2
    ;;
esac
