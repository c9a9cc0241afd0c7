#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
#
# Installs the Debian packages that are missing; does nothing, and needs no rights, when none is.
#   setup-debian.sh build    what building, running and plotting need
#   setup-debian.sh check    also what the tests need
#   setup-debian.sh bench    what `build` needs and the programs that ryusa is compared with (half a gigabyte)
set -eu

packages="cmake gcc libc6-dev make pkg-config libhdf5-dev libfftw3-dev libyaml-dev libudunits2-dev
          libgsl-dev libnlopt-dev librandom123-dev python3-h5py python3-matplotlib python3-pil"
if [ "${1:-build}" = check ]; then
    packages="$packages libcmocka-dev g++ clang libomp-dev valgrind
              libopenmpi-dev openmpi-bin slurmctld slurmd slurm-client munge"
elif [ "${1:-build}" = bench ]; then
    packages="$packages python3-numpy lammps liggghts yade"
fi

if ! command -v dpkg-query >/dev/null; then
    echo "This is not Debian: nothing is installed. Needed are the equivalents of: $packages" >&2
    exit 0
fi

missing=""
for package in $packages; do
    case "$(dpkg-query -W -f='${Status}' "$package" 2>/dev/null || true)" in
    *" installed") ;;
    *) missing="$missing $package" ;;
    esac
done
[ -n "$missing" ] || exit 0

if [ "$(id -u)" -eq 0 ]; then
    as_root="env"
elif command -v sudo >/dev/null; then
    as_root="sudo env"
else
    echo "These packages are missing, and there is neither root nor sudo to install them:$missing" >&2
    echo "Ask an administrator for: apt-get install --no-install-recommends$missing" >&2
    exit 1
fi

log=$(mktemp)
trap 'rm -f "$log"' EXIT
quietly() {
    if ! $as_root DEBIAN_FRONTEND=noninteractive apt-get -qq -o Dpkg::Use-Pty=0 "$@" >"$log" 2>&1 </dev/null; then
        tail -n 20 "$log" >&2
        return 1
    fi
}
echo "Installing:$missing"
quietly update || echo "The package lists could not be renewed; going on with those that are there." >&2
# shellcheck disable=SC2086  # a list of words
if ! quietly install -y --no-install-recommends $missing; then
    echo "The packages could not be installed (see above):$missing" >&2
    exit 1
fi
