#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Shows that the two commands of the README are enough on a machine that has only git: see usage below.
#
# Everything is mounted in a private mount namespace, and nothing of the machine is mounted into the root but, in the
# short form, /usr as the read-only layer of an overlay. The namespace ends before the folder is deleted, so cleaning up
# cannot reach the machine.
set -uo pipefail

usage() {
  cat <<'TEXT'
Usage: toolchain/bare_root_test.sh [options]          (as root)

Makes a fresh, minimal Debian in a folder, adds git, clones the project's last commit into it, and checks that
  - an ordinary user without sudo is given the one apt-get line and exit code 4,
  - `./voltlap endurance --yes` installs what it needs and no more, builds and drives,
  - the next start is quick,
  - `./voltlap test --yes` passes,
  - with the packages there, an ordinary user needs no root.
It takes 10 to 30 minutes and 5 GB, which are freed at the end.

  --short          no download and no build, a few seconds: the root borrows this machine's /usr, read-only, its dpkg
                   knows only the essential packages, and a stand-in for apt-get records what would be installed
  --suite NAME     release for debootstrap (bookworm)
  --mirror URL     package mirror (http://deb.debian.org/debian)
  --components A,B archive components (main)
  --apt-conf FILE  configuration for the root's apt, for a proxy say
  --ca FILE        certificates that pip trusts, behind a proxy with its own authority
  --folder DIR     where the root is made (TMPDIR, else /tmp)
  --log FILE       the output of all commands (voltlap-bare-root.log in that folder)
  http_proxy, https_proxy, no_proxy, PIP_INDEX_URL are passed on.

Exit codes: 0 all shown, 1 something was not, 2 usage, 77 cannot be done here (not root, no namespaces, no debootstrap).
TEXT
}

readonly cannot=77
short=0 suite=bookworm mirror=http://deb.debian.org/debian components=main apt_conf='' ca='' inside='' log=''
folder=${TMPDIR:-/tmp}
project=$(cd "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/.." && pwd)
arguments=("$@")
while [ $# -gt 0 ]; do
  case "$1" in
    --short) short=1 ;;
    --suite | --mirror | --components | --apt-conf | --ca | --folder | --log | --inside)
      [ $# -gt 1 ] || { echo "$1 needs a value; see --help" >&2; exit 2; }
      name=${1#--}
      printf -v "${name//-/_}" '%s' "$2"
      shift
      ;;
    --help | -h) usage; exit 0 ;;
    *) echo "unknown option $1; see --help" >&2; exit 2 ;;
  esac
  shift
done
log=${log:-$folder/voltlap-bare-root.log}

# ---- outside the namespace: make the folder, start the namespace, delete the folder ----

unable() { echo "bare root test: $*" >&2; exit $cannot; }

mounts_below() { awk -v at="$1/" 'index($5 "/", at) == 1 { print $5 }' /proc/self/mountinfo; }

# Deletes the folder made here, and nothing that is a mount.
clean_up() {
  [ -d "$scratch" ] || return 0
  local left
  left=$(mounts_below "$scratch")
  if [ -n "$left" ]; then
    echo "bare root test: still mounted, so $scratch is left: $left" >&2
    return 1
  fi
  rm -rf --one-file-system "$scratch"
}

outside() {
  [ "$(id -u)" = 0 ] || unable 'making a root and its devices needs root'
  [ $short = 1 ] || type -P debootstrap >/dev/null || unable 'debootstrap is missing (apt-get install debootstrap)'
  unshare --mount --pid --fork true 2>/dev/null || unable 'this kernel or container allows no mount namespace'
  scratch='' namespace=''
  trap clean_up EXIT
  trap interrupted INT TERM
  scratch=$(mktemp -d "$(readlink -f "$folder")/voltlap-bare-root.XXXXXX") || exit $cannot
  unshare --mount --pid --fork --kill-child -- \
    bash "${BASH_SOURCE[0]}" "${arguments[@]}" --log "$log" --inside "$scratch" &
  namespace=$!
  wait $namespace
}

# Ends the first process of the namespace: all others, and the mounts, go with it before `wait` returns.
interrupted() {
  if [ -n "$namespace" ]; then
    local first
    first=$(cat "/proc/$namespace/task/$namespace/children" 2>/dev/null)
    kill -KILL "${first:-$namespace}" 2>/dev/null
    wait "$namespace"
  fi
  exit 130
}

# ---- inside: the root and the steps ----

step() { printf '%s  %s\n' "$(date +%T)" "$*"; }

failed() {
  step "NOT SHOWN: $*"
  tail -n 30 "$log"
  exit 1
}

# A terminal, the usual device files, and processes of this namespace only.
mount_devices() {
  local name
  mkdir -p "$root/dev" "$root/proc"
  mount -t tmpfs -o mode=755,size=64m tmpfs "$root/dev"
  mknod -m 666 "$root/dev/null" c 1 3
  mknod -m 666 "$root/dev/zero" c 1 5
  mknod -m 666 "$root/dev/full" c 1 7
  mknod -m 666 "$root/dev/random" c 1 8
  mknod -m 666 "$root/dev/urandom" c 1 9
  mknod -m 666 "$root/dev/tty" c 5 0
  mkdir -p "$root/dev/pts" "$root/dev/shm"
  mount -t devpts -o newinstance,ptmxmode=0666,mode=0620 devpts "$root/dev/pts"
  mount -t tmpfs -o mode=1777 tmpfs "$root/dev/shm"
  ln -s pts/ptmx "$root/dev/ptmx"
  ln -s /proc/self/fd "$root/dev/fd"
  for name in stdin:0 stdout:1 stderr:2; do ln -s "fd/${name#*:}" "$root/dev/${name%:*}"; done
  mount -t proc proc "$root/proc"
}

# A root as debootstrap makes it, with git.
make_debian() {
  step "debootstrap --variant=minbase $suite (root has git and ca-certificates, nothing else)"
  debootstrap --variant=minbase --include=git,ca-certificates --components="$components" "$suite" "$root" "$mirror" \
    >>"$log" 2>&1 || failed 'debootstrap'
  mount_devices
  cp /etc/resolv.conf "$root/etc/resolv.conf"
  [ -z "$apt_conf" ] || cp "$apt_conf" "$root/etc/apt/apt.conf.d/99voltlap"
  [ -z "$ca" ] || cp "$ca" "$root/usr/local/share/voltlap-ca.pem"
  in_root 0 useradd --create-home driver
}

# What dpkg would know on a machine with nothing but git.
describe_essential_packages() {
  local essential package version arch
  # shellcheck disable=SC2016
  dpkg-query -W -f='${Essential} ${Package} ${Version} ${Architecture}\n' >"$scratch/packages"
  while read -r essential package version arch; do
    [ "$essential" = yes ] || [ "$package" = git ] || continue
    printf 'Package: %s\nStatus: install ok installed\nVersion: %s\nArchitecture: %s\n' "$package" "$version" "$arch"
    printf 'Maintainer: nobody <nobody@localhost>\nDescription: %s\n\n' "$package"
  done <"$scratch/packages"
}

# A root of this machine's programs, with a dpkg that knows the essential packages and git, no sudo, and an apt-get that
# writes down what it is told and fails.
make_borrowed() {
  step "a root that borrows this machine's /usr"
  local name
  mount -t tmpfs -o mode=755 tmpfs "$scratch" && mkdir -p "$root"/{usr,etc,tmp,root,home/driver} "$root/var/lib/dpkg" \
    "$scratch/upper" "$scratch/work"
  mount -t overlay -o "lowerdir=/usr,upperdir=$scratch/upper,workdir=$scratch/work" overlay "$root/usr" 2>>"$log" ||
    unable 'this kernel or container allows no overlay'
  for name in bin sbin lib lib64; do ln -s "usr/$name" "$root/$name"; done
  cp -a /etc/ld.so.cache /etc/alternatives "$root/etc/"
  printf 'root:x:0:0::/root:/bin/bash\ndriver:x:1000:1000::/home/driver:/bin/bash\n' >"$root/etc/passwd"
  chmod 1777 "$root/tmp"
  chown 1000:1000 "$root/home/driver"
  mount_devices
  mkdir -p "$root/var/lib/dpkg/info" "$root/var/lib/dpkg/updates"
  describe_essential_packages >"$root/var/lib/dpkg/status"
  rm -f "$root/usr/bin/sudo"
  printf '#!/bin/sh\necho "$@" >>/apt-get.log\nexit 100\n' >"$scratch/apt-get"
  install -m 755 "$scratch/apt-get" "$root/usr/bin/apt-get"
}

# in_root UID COMMAND...: as that user, with a clean environment.
in_root() {
  local user=$1 home=/root
  local clean=(PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 TERM=dumb)
  shift
  [ "$user" = 0 ] || home=/home/driver
  local name
  for name in http_proxy https_proxy no_proxy PIP_INDEX_URL; do [ -z "${!name:-}" ] || clean+=("$name=${!name}"); done
  [ -z "$ca" ] || clean+=(PIP_CERT=/usr/local/share/voltlap-ca.pem SSL_CERT_FILE=/usr/local/share/voltlap-ca.pem)
  chroot "$root" /usr/bin/setpriv --reuid="$user" --regid="$user" --clear-groups -- \
    env -i HOME="$home" "${clean[@]}" "$@" </dev/null
}

# voltlap UID ARGUMENT...: ./voltlap in that user's clone; sets code, took, and leaves the output in $scratch/output.
voltlap() {
  local user=$1 begin=$SECONDS
  shift
  # shellcheck disable=SC2016
  in_root "$user" bash -c 'cd ~/voltlap && ./voltlap "$@"' _ "$@" >"$scratch/output" 2>&1
  code=$?
  took=$((SECONDS - begin))
  { echo "--- $user: ./voltlap $*"; cat "$scratch/output"; } >>"$log"
}

said() { grep -q -E -e "$1" "$scratch/output"; }

# The start script leaves out what the distribution does not have; Debian 12 has everything.
has_every_package() { [ $suite != bookworm ] || ! said 'done without' || failed 'a package is left out for nothing'; }

# What a run does not install: the cross compiler, a browser, the tests' packages.
readonly not_for_a_run='arm-none-eabi|chromium|cpputest|libbenchmark|can-utils|user-mode-linux|clang'

clone() {
  local user
  git -C "$project" bundle create "$root/voltlap.bundle" HEAD >>"$log" 2>&1 || failed 'git bundle'
  [ -z "$(git -C "$project" status --porcelain)" ] || step 'note: changes that are not committed are not tested'
  for user in 0 1000; do
    # shellcheck disable=SC2016
    in_root $user bash -c 'git clone -q /voltlap.bundle ~/voltlap' >>"$log" 2>&1 ||
      failed "git clone as user $user"
  done
}

ordinary_user_is_given_the_line() {
  local command
  for command in endurance test; do
    voltlap 1000 $command --yes
    [ $code = 4 ] || failed "an ordinary user's $command ends with 4, but it was $code"
    [ "$(grep -c 'apt-get update && apt-get install' "$scratch/output")" = 1 ] || failed 'one apt-get line is printed'
    has_every_package
    [ $command = test ] || ! said "$not_for_a_run" || failed 'the line for a run holds nothing that only tests need'
    [ $command = endurance ] || said 'gcc-arm-none-eabi' || failed 'the line for the tests holds the cross compiler'
  done
  step 'ordinary user without sudo: the apt-get line, exit code 4'
}

root_would_install_the_same() {
  voltlap 0 endurance
  { [ $code = 4 ] && [ ! -f "$root/apt-get.log" ]; } || failed 'nothing is installed without consent'
  voltlap 0 endurance --yes
  [ $code = 4 ] || failed "a failed installation ends with 4, but it was $code"
  said 'by hand' || failed 'a failed installation says how to do it by hand'
  grep -q '^update' "$root/apt-get.log" || failed 'apt-get update is called'
  step 'root: asks first; with --yes apt-get is called'
}

endurance_runs() {
  voltlap 0 endurance --yes
  { [ $code = 0 ] && said '^Finished '; } || failed "./voltlap endurance --yes as root (exit code $code)"
  has_every_package
  # shellcheck disable=SC2016
  in_root 0 dpkg-query -W -f='${Status} ${Package}\n' >"$scratch/installed"
  ! grep -E "^install ok installed .*($not_for_a_run)" "$scratch/installed" ||
    failed 'a run installs only what it needs'
  [ ! -e "$root/root/voltlap/build/venv/bin/pytest" ] || failed 'a run needs no pytest'
  step "root: endurance, set-up and build included, in $took s; $(du -sm --one-file-system "$root" | cut -f1) MB in all"
  voltlap 0 lap
  { [ $code = 0 ] && [ $took -le 2 ]; } || failed "the next start is quick, but took $took s"
  step "root: the next start took $took s"
}

tests_pass() {
  voltlap 0 test --yes
  [ $code = 0 ] || failed "./voltlap test --yes as root (exit code $code)"
  has_every_package
  step "root: test in $took s: $(tail -n 1 "$scratch/output")"
}

user_needs_no_root() {
  voltlap 1000 endurance --yes
  { [ $code = 0 ] && said '^Finished '; } ||
    failed "./voltlap endurance as an ordinary user, packages there (exit code $code)"
  step "ordinary user, packages there: endurance in $took s"
}

inside() {
  scratch=$inside root=$inside/root
  : >"$log"
  if [ $short = 1 ]; then
    make_borrowed
    clone
    ordinary_user_is_given_the_line
    root_would_install_the_same
  else
    make_debian
    clone
    ordinary_user_is_given_the_line
    endurance_runs
    tests_pass
    user_needs_no_root
  fi
  step 'all shown'
}

if [ -n "$inside" ]; then inside; else outside; fi
exit
