#!/usr/bin/env bash
# Installs what drt needs from Debian (12 or 13): a C compiler, Embree's headers and libclang, which
# reads them. Only what is missing; when nothing is, no network and no root is needed.
set -euo pipefail
cd "$(dirname "$0")"

packages=(build-essential libembree-dev libclang-dev)

say() { printf 'setup: %s\n' "$*" >&2; }
fail() { say "$*"; exit 1; }

installed() { [ "$(dpkg-query -W -f '${db:Status-Status}' "$1" 2>/dev/null)" = installed ]; }

# True when version $1 is at least $2.
at_least() { [ "$(printf '%s\n%s\n' "$2" "$1" | sort -V | head -n 1)" = "$2" ]; }

install_packages() {
  command -v dpkg-query >/dev/null ||
    fail "this is not Debian: install a C compiler, Embree 3.13 or 4 and libclang by hand, or build with --no-default-features"
  local missing=() package
  for package in "${packages[@]}"; do
    installed "$package" || missing+=("$package")
  done
  [ ${#missing[@]} -gt 0 ] || return 0

  local as_root=()
  if [ "$(id -u)" != 0 ]; then
    command -v sudo >/dev/null || fail "run as root: apt-get install ${missing[*]}"
    as_root=(sudo)
  fi
  say "installing ${missing[*]}"
  log=$(mktemp)
  trap 'rm -f "$log"' EXIT
  if ! { "${as_root[@]}" apt-get update &&
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
      apt-get install -y --no-install-recommends "${missing[@]}"; } >"$log" 2>&1; then
    cat "$log" >&2
    fail "apt-get could not install ${missing[*]}"
  fi
}

check_cargo() {
  local wanted found
  wanted=$(sed -n 's/^rust-version = "\(.*\)"/\1/p' Cargo.toml | head -n 1)
  command -v cargo >/dev/null ||
    fail "cargo was not found; get Rust $wanted or newer with rustup (https://rustup.rs)"
  found=$(cargo --version 2>/dev/null | sed 's/^cargo \([0-9.]*\).*/\1/')
  [ -n "$found" ] || fail "cargo does not run; get Rust $wanted or newer with rustup (https://rustup.rs)"
  at_least "$found" "$wanted" ||
    fail "cargo $found is older than $wanted; run 'rustup update', or get rustup from https://rustup.rs"
}

install_packages
check_cargo
say "ready: cargo build --release"
