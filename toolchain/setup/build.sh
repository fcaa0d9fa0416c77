# SPDX-License-Identifier: Apache-2.0
# Part of the start script `voltlap`: configures when needed and builds; quiet and quick when nothing has changed.

build_log="$project/build/build.log"

# One start script at a time sets up and builds; the lock goes before the command runs.
take_build_folder() {
  if ! mkdir -p "$project/build" 2>/dev/null || [ ! -w "$project/build" ]; then
    say "$project/build cannot be written, and everything that is built goes there."
    say "Copy or clone the project into a folder of your own and start it there."
    exit $exit_missing
  fi
  exec 9>"$project/build/lock"
  type -P flock >/dev/null || return 0
  flock -n 9 && return 0
  say "another start of voltlap is building; waiting for it"
  flock 9
}

release_build_folder() { exec 9>&-; }

cache_entry() { sed -n "s/^$1:[A-Z]*=//p" "$build/CMakeCache.txt" 2>/dev/null; }

# A build folder knows its place by absolute paths: after a move it starts afresh.
forget_moved_build() {
  local home
  home=$(cache_entry CMAKE_HOME_DIRECTORY)
  if [ -n "$home" ] && [ "$home" != "$project" ]; then
    say "the project has moved here from $home; it is built anew"
    rm -rf --one-file-system "$build"
  fi
}

# Options that the row wants and the build folder does not have yet, as flags of cmake.
missing_options() {
  local option
  for option in $row_options; do [ "$(cache_entry "$option")" = ON ] || printf -- '-D%s=ON ' "$option"; done
}

# build.ninja is written last, so a broken-off first configuration is repeated.
configure() {
  local flags
  forget_moved_build
  if [ ! -f "$build/build.ninja" ]; then
    say "building for the first time; this takes a few minutes"
    flags="-DVOLTLAP_LEARN=OFF -DVOLTLAP_TESTS=OFF $(missing_options)"
  else
    flags=$(missing_options)
    [ -n "$flags" ] || return 0
  fi
  with_ticker configuring run_cmake $flags || build_failed
}

run_cmake() { (cd "$project" && cmake --preset default "$@") 9>&- >"$build_log" 2>&1; }

# build_target [ARGUMENT]...: the targets of the row; the arguments are those of its command.
build_target() {
  [ -n "$row_target" ] || return 0
  configure
  local targets=$row_target
  if [ "$targets" = asked ]; then
    ninja -C "$build" build.ninja 9>&- >"$build_log" 2>&1 || build_failed
    targets=$("$venv/bin/python" "$project/${row_runs#* }" --targets "$@") || exit
  fi
  ninja -C "$build" -j "$(build_jobs)" $targets 9>&- 2>&1 | tee "$build_log" | show_progress
  [ "${PIPESTATUS[0]}" = 0 ] || build_failed
}

# The image that an emulated board runs.
build_image() {
  "$venv/bin/python" "$project/toolchain/image.py" 9>&- >"$build_log" 2>&1 || build_failed
}

# A compiler takes up to 0.7 GB: small machines build fewer files at a time.
build_jobs() {
  local cpus free_kb jobs
  cpus=$(nproc)
  free_kb=$(sed -n 's/^MemAvailable: *\([0-9]*\).*/\1/p' /proc/meminfo 2>/dev/null)
  jobs=$(((${free_kb:-1000000000}) / 700000))
  [ $jobs -le "$cpus" ] || jobs=$cpus
  [ $jobs -ge 1 ] || jobs=1
  echo $jobs
}

# One line that counts up on a terminal, every fortieth step elsewhere; nothing when there is nothing to build.
show_progress() {
  local line shown=0 step
  while IFS= read -r line; do
    [[ "$line" =~ ^\[([0-9]+)/([0-9]+)\] ]] || continue
    step="${BASH_REMATCH[1]}/${BASH_REMATCH[2]}"
    if [ -t 2 ]; then
      printf '\rvoltlap: building %s   ' "$step" >&2
      shown=1
    elif [ "${BASH_REMATCH[1]}" != 0 ] && [ $((BASH_REMATCH[1] % 40)) = 0 ]; then
      say "building $step"
    fi
  done
  if [ $shown = 1 ]; then printf '\r%40s\r' '' >&2; fi
  return 0
}

# By what was printed; or, where not even that could be written, by what is free.
disk_is_full() {
  grep -q -i 'no space left on device\|not enough free space' "$1" 2>/dev/null ||
    [ "$(df -Pk "$project/build" 2>/dev/null | sed -n '2s/ *[^ ]* *[^ ]* *[^ ]* *\([0-9]*\).*/\1/p')" -lt 1000 ] 2>/dev/null
}

build_failed() {
  if grep -q -E 'error|Error|FAILED' "$build_log"; then
    grep -E -A5 'error|Error|FAILED' "$build_log" | head -n 40 >&2
  else
    tail -n 30 "$build_log" >&2
  fi
  say "the build failed (whole log: $build_log)."
  if disk_is_full "$build_log"; then
    say "The disk is full. Make room and start again; what is built so far is kept."
  elif grep -q -E 'Killed|out of memory' "$build_log"; then
    say "The compiler ran out of memory. Close other programs and start again; what is built so far is kept."
  else
    say "If you changed nothing, remove the folder build/ and start again."
  fi
  exit $exit_build
}
