# SPDX-License-Identifier: Apache-2.0
# Part of the start script `voltlap`: finds a command's row in its table, prints help, runs the command.

readonly exit_usage=2 exit_missing=4 exit_build=5 exit_interrupted=130

say() { printf 'voltlap: %s\n' "$*" >&2; }

# with_ticker TEXT COMMAND...: says what is done; on a terminal seconds count up beside it.
ticker=''
with_ticker() {
  local text=$1 begin=$SECONDS code
  shift
  if [ -t 2 ]; then
    while kill -0 $$ && printf '\rvoltlap: %s (%d s) ' "$text" $((SECONDS - begin)); do sleep 1; done 9>&- >&2 &
    ticker=$!
  else
    say "$text"
  fi
  "$@"
  code=$?
  stop_ticker
  return $code
}

stop_ticker() {
  [ -n "$ticker" ] || return 0
  kill "$ticker"
  wait "$ticker" 2>/dev/null
  ticker=''
  echo >&2
}

# row NAME RUNS PACKAGES PYTHON OPTIONS TARGET ARGUMENTS WHAT: one row. What is done with it depends on row_action.
row() { "$row_action" "$@"; }

list_row() { printf '  ./voltlap %-28s %s\n' "$1${7:+ $7}" "$8"; }

# Keeps the row of the command that was asked for in row_*. A row may be of a command and its first argument
# (`list causes`); it stands after that of the command.
find_row() {
  [ "$1" = "$row_name" ] || [ "$1" = "$row_name $row_first_argument" ] || return 0
  row_found=1 row_runs=$2 row_packages=$3 row_python=$4 row_options=$5 row_target=$6 row_arguments=$7 row_what=$8
}

usage() {
  echo 'Voltlap: an electric race car, its battery and its control firmware on one CAN bus.'
  echo
  row_action=list_row
  command_table
  cat <<'TEXT'
  ./voltlap --version
  ./voltlap COMMAND --help       all flags of a command

The first run says what is missing, asks once and installs it (--yes or CI=true: no question), and builds; that takes
minutes. Everything it makes lies in build/.
TEXT
  exit_codes
}

exit_codes() {
  cat <<'TEXT'
Exit codes: 0 done, 1 a test failed, 2 usage or input, 3 the run failed, 4 packages are missing, 5 the build failed,
70 memory ran out or a defect, 130 interrupted.
TEXT
}

# What the start script adds to the help of every command.
help_footer() {
  echo
  echo 'The start script takes --yes too: install what is missing without asking.'
  exit_codes
}

help_of_build() {
  printf 'Usage: ./voltlap %s [--yes]\n\n%s. It takes no other argument.\n' "$row_name" "${row_what^}"
  printf 'Packages it needs: %s\n' "$(packages_of_row)"
}

# Help comes without building, except for a program that has never been built: it prints its own flags.
show_help() {
  local program=${row_runs#* } inner=()
  [[ "${arguments[0]:--}" == -* ]] || inner=("${arguments[0]}")  # `track import` has a help of its own
  case "$row_runs" in
    nothing) help_of_build ;;
    python\ *) help_of_python "$project/$program" ;;
    bash\ *) bash "$project/$program" --help ;;
    wrap\ *) "$(base_python)" "$project/$program" --help ;;
    cli\ *) help_of_program "$program" "$row_name" "${inner[@]}" ;;
    program\ *) help_of_program "$program" ;;
  esac || exit
  help_footer
}

help_of_python() {
  local python="$venv/bin/python"
  [ -x "$python" ] || python=python3
  if ! type -P "$python" >/dev/null; then
    prepare
    python="$venv/bin/python"
  fi
  "$python" "$1" --help
}

# help_of_program PROGRAM [ARGUMENT]: of a program in bin/ of the build folder.
help_of_program() {
  local text program="$build/bin/$1"
  shift
  # A program older than the command does not know it; then it is built after all.
  if ! text=$("$program" "$@" --help 2>/dev/null); then
    say "the flags of \"$row_name\" are printed by the program, which is built first"
    prepare
    build_target
    text=$("$program" "$@" --help) || return
  fi
  printf '%s\n' "$text"
}

run_command() {
  local program=${row_runs#* }
  release_build_folder
  export VOLTLAP_BUILD_DIR="$build"
  case "$row_runs" in
    nothing) say "everything is built" ;;
    python\ *) exec "$venv/bin/python" "$project/$program" "$@" ;;
    bash\ *) exec bash "$project/$program" "$@" ;;
    wrap\ *) exec "$(base_python)" "$project/$program" "$@" ;;
    cli\ *) exec "$build/bin/$program" "$row_name" "$@" ;;
    program\ *) exec "$build/bin/$program" "$@" ;;
  esac
}

# The start script's own flags are taken out of the arguments; those of a wrapped command are left to it.
read_arguments() {
  local argument own=1
  yes=0 help=0 arguments=()
  for argument in "$@"; do
    case "$row_runs" in wrap\ *) [[ "$argument" == -* ]] || own=0 ;; esac
    case "$own$argument" in
      1--yes) yes=1 ;;
      1--help | 1-h) help=1 ;;
      *) arguments+=("$argument") ;;
    esac
  done
  [ "${CI:-}" = true ] && yes=1
  return 0
}

# A command of this script behind a wrapper gets what it needs here, where the network is: the wrapper may have none.
prepare_wrapped() {
  while [ $# -gt 1 ] && [ "$(readlink -f -- "$1")" != "$project/voltlap" ]; do shift; done
  [ $# -gt 1 ] || return 0
  row_name=$2 row_first_argument=${3:-} row_found=0
  command_table
  [ $row_found = 1 ] || return 0
  shift 2
  prepare
  build_target "$@"
}

# Whether the arguments ask for the emulated board: its image is built like a program. One that is named is there.
drives_emulator() {
  local argument before='' asked=1
  for argument in "$@"; do
    case "$before $argument" in
      *' --image' | *' --image='*) return 1 ;;
      '--ecu qemu' | *' --ecu=qemu') asked=0 ;;
    esac
    before=$argument
  done
  return $asked
}

version() { sed -n 's/^project(voltlap VERSION \([0-9.]*\).*/voltlap \1/p' "$project/CMakeLists.txt"; }

voltlap_main() {
  local first_yes=()
  if [ "${1:-}" = --yes ]; then
    first_yes=(--yes)
    shift
  fi
  case "${1:-}" in
    '' | --help | -h | help)
      usage
      exit 0
      ;;
    --version)
      version
      exit 0
      ;;
  esac
  row_name=$1 row_first_argument=${2:-} row_found=0 row_action=find_row
  shift
  command_table
  if [ $row_found = 0 ]; then
    say "there is no command \"$row_name\"; ./voltlap --help lists those that exist"
    exit $exit_usage
  fi
  read_arguments "${first_yes[@]}" "$@"
  if [ $help = 1 ]; then
    show_help
    exit
  fi
  if [ "$row_runs" = nothing ] && [ ${#arguments[@]} -gt 0 ]; then
    say "\"$row_name\" takes no argument \"${arguments[0]}\"; see ./voltlap $row_name --help"
    exit $exit_usage
  fi
  trap 'stop_ticker; say "interrupted; the next start goes on from here"; exit $exit_interrupted' INT TERM
  local emulated=0
  if drives_emulator "${arguments[@]}"; then
    emulated=1 row_packages+=' cross emulator'
  fi
  prepare
  build_target "${arguments[@]}"
  [ $emulated = 0 ] || build_image
  if [[ "$row_runs" == wrap\ * ]]; then
    release_build_folder
    (prepare_wrapped "${arguments[@]}") || exit
  fi
  run_command "${arguments[@]}"
}
