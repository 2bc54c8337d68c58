#!/usr/bin/env bash
# drt on Debian 13 (Embree 4): the tests of the backends and one render, in a root of their own.
#
#   sudo tests/debian13.sh [DIRECTORY]
#
# DIRECTORY (default: drt-debian13 in $TMPDIR or /tmp; some 2.5 GB) receives the root, made with debootstrap, and the
# build. It stays, so that a second run only builds and tests; remove it by `rm -r`. The compiler is this machine's:
# the toolchain, cargo's downloads and the project are mounted read-only, in a mount namespace that ends with the script
# however it ends, so nothing stays mounted. Building there uses the root's headers, libclang and library.
set -euo pipefail

suite=trixie
mirror=${DEBIAN_MIRROR:-http://deb.debian.org/debian}
project=$(cd "$(dirname "$0")/.." && pwd)

say() { printf 'debian13: %s\n' "$*" >&2; }
fail() { say "$*"; exit 1; }

# What is not there is said at once, all of it.
check() {
  local missing=() tool
  [ "$(id -u)" = 0 ] || missing+=("root's rights (sudo $0)")
  for tool in debootstrap chroot mount unshare; do
    command -v "$tool" >/dev/null || missing+=("$tool (apt-get install debootstrap util-linux)")
  done
  command -v cargo >/dev/null || missing+=("cargo (https://rustup.rs; under sudo: sudo env PATH=\"\$PATH\" $0)")
  [ ${#missing[@]} = 0 ] && return
  for tool in "${missing[@]}"; do say "missing: $tool"; done
  exit 1
}

# Makes the root and installs what setup.sh would; a step that is done is not done again.
make_root() {
  if [ ! -e "$root/.made" ]; then
    [ ! -e "$root" ] || [ -z "$(ls -A "$root")" ] || [ -e "$root/debootstrap" ] || [ -e "$root/.making" ] ||
      fail "$root is there and is no root of this script"
    mkdir -p "$root"
    touch "$root/.making"
    say "debootstrap $suite into $root"
    debootstrap --variant=minbase "$suite" "$root" "$mirror" >"$root.log" 2>&1 ||
      { tail -5 "$root.log" >&2; fail "debootstrap failed; all of it: $root.log"; }
    touch "$root/.made"
  fi
  if [ ! -e "$root/.installed" ]; then
    local packages
    packages=$(sed -n 's/^packages=(\(.*\))$/\1/p' "$project/setup.sh")
    [ -n "$packages" ] || fail "setup.sh has no list of packages"
    say "installing $packages"
    cp /etc/resolv.conf "$root/etc/resolv.conf"
    # shellcheck disable=SC2086
    { inside apt-get update && inside apt-get install -y --no-install-recommends $packages; } >>"$root.log" 2>&1 ||
      { tail -5 "$root.log" >&2; fail "apt-get failed in the root; all of it: $root.log"; }
    touch "$root/.installed"
  fi
}

# Runs a command in the root.
inside() {
  chroot "$root" /usr/bin/env -i PATH="$toolchain/bin:/usr/sbin:/usr/bin:/sbin:/bin" HOME=/root LC_ALL=C.UTF-8 \
    DEBIAN_FRONTEND=noninteractive CARGO_HOME="$cargo_home" CARGO_NET_OFFLINE=true \
    CARGO_TARGET_DIR=/var/drt-target DRT_HEAVY_TESTS="${DRT_HEAVY_TESTS:-}" \
    sh -c 'cd /drt 2>/dev/null; exec "$@"' sh "$@"
}

# A directory of this machine, read-only and at the same place in the root (or at $2).
show() {
  local at=$root${2:-$1}
  mkdir -p "$at"
  mount --bind "$1" "$at"
  mount -o remount,bind,ro "$at"
}

if [ "${DRT_DEBIAN13_INSIDE:-}" != 1 ]; then
  check
  # Mounts made from here on are seen by nobody else and vanish with the last process.
  DRT_DEBIAN13_INSIDE=1 exec unshare --mount --propagation private -- "$0" "$@"
fi

root=${1:-${TMPDIR:-/tmp}/drt-debian13}
mkdir -p "$(dirname "$root")"
root=$(realpath "$root")
toolchain=$(cd "$project" && rustc --print sysroot)
cargo_home=${CARGO_HOME:-$HOME/.cargo}

make_root
(cd "$project" && cargo fetch --locked --quiet) || fail "cargo could not fetch what Cargo.lock names"
mount -t proc proc "$root/proc"
mount --rbind /dev "$root/dev"
show "$project" /drt
show "$toolchain"
show "$cargo_home"

say "Debian $(cat "$root/etc/debian_version"), Embree $(inside dpkg-query -W -f '${Version}' libembree-dev)"
inside cargo build --release --locked
inside cargo test --release --locked -p embree-sys -p drt --lib accel::
inside cargo test --release --locked --test backends
inside /var/drt-target/release/drt --version | tee "$root/var/version"
grep -q 'Embree 4\.' "$root/var/version" || fail "the program was not linked with Embree 4"
inside sh -c 'ldd /var/drt-target/release/drt' | grep libembree4 >&2
for backend in embree bvh; do
  inside /var/drt-target/release/drt scenes/cornell-box.toml --backend "$backend" --spp 16 --progress none \
    -o "/var/cornell-$backend.exr"
done
inside /var/drt-target/release/drt compare /var/cornell-embree.exr /var/cornell-bvh.exr
say "all of it passed"
