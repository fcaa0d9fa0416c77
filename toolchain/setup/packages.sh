# SPDX-License-Identifier: Apache-2.0
# Part of the start script `voltlap`: Debian packages and the Python virtual environment that a command needs.
# One question for both; nothing is installed without consent.

venv="$project/build/venv"
# Optional packages (with ? in the table) that this distribution does not have.
unavailable="$project/build/packages_unavailable"
# What the virtual environment was made from, kept inside it: written last, so that a broken-off installation has none.
venv_record="$venv/voltlap.record"

# The packages of the row's groups, in one line.
packages_of_row() {
  local group all=()
  for group in $row_packages; do
    local -n group_packages="packages_$group"
    all+=("${group_packages[@]}")
  done
  echo "${all[*]}"
}

# The packages given that are not installed, in one line; optional ones keep their ?. One call of dpkg-query: it is made
# at every start.
missing_packages() {
  [ $# -gt 0 ] || return 0
  local name status there=' '
  while read -r name status; do
    [ "$status" = installed ] && there+="$name "
  done < <(dpkg-query -W -f='${Package} ${db:Status-Status}\n' "${@%\?}" 2>/dev/null)
  [ ! -f "$unavailable" ] || there+="$(tr '\n' ' ' <"$unavailable")"
  local lacking=()
  for name in "$@"; do [[ "$there" == *" ${name%\?} "* ]] || lacking+=("$name"); done
  echo "${lacking[*]}"
}

apt_has() {
  local policy
  policy=$(LC_ALL=C apt-cache policy "$1")
  [[ "$policy" == *'Candidate: '[!\(]* ]]
}

# Takes out of `missing` the optional packages that the distribution does not have, and keeps them in mind. What there
# is, apt knows only after an update.
drop_unavailable() {
  [[ "$missing" == *\?* ]] && compgen -G '/var/lib/apt/lists/*_Packages*' >/dev/null || return 0
  local name kept=()
  for name in $missing; do
    if [[ "$name" == *\? ]] && ! apt_has "${name%\?}"; then
      say "this distribution has no ${name%\?}; done without"
      echo "${name%\?}" >>"$unavailable"
    else
      kept+=("$name")
    fi
  done
  missing="${kept[*]}"
}

# What a virtual environment with the sets given is made from: the folder (it does not survive a move), the Python, and
# the text of the sets.
venv_recipe() {
  local set
  printf '%s\n%s\n' "$project" "$(readlink -f "$(base_python)")"
  for set in "$@"; do printf '[%s]\n%s\n' "$set" "$(<"$project/toolchain/requirements/$set.txt")"; done
}

# The distribution's Python: the packages above belong to it.
base_python() { if [ -x /usr/bin/python3 ]; then echo /usr/bin/python3; else echo python3; fi; }

# The sets that the environment must have: the row's, and those it has already.
venv_sets() {
  local set sets=" $row_python "
  while IFS= read -r set; do
    [[ "$set" =~ ^\[([a-z_]+)\]$ ]] || continue
    set=${BASH_REMATCH[1]}
    [[ "$sets" == *" $set "* ]] || [ ! -f "$project/toolchain/requirements/$set.txt" ] || sets+="$set "
  done < <(cat "$venv_record" 2>/dev/null)
  # In alphabetical order, so that the record does not depend on which command came first.
  for set in "$project"/toolchain/requirements/*.txt; do
    set=${set##*/}
    [[ "$sets" == *" ${set%.txt} "* ]] && printf '%s ' "${set%.txt}"
  done
}

venv_is_ready() {
  [ -z "$row_python" ] && return 0
  [ -x "$venv/bin/python" ] && [ "$(cat "$venv_record" 2>/dev/null)" = "$(venv_recipe $(venv_sets))" ]
}

# prepare: everything that the row needs is installed when it returns; else it ends with exit code 4.
prepare() {
  local packages missing='' want_venv=0
  take_build_folder
  packages=$(packages_of_row)
  if type -P dpkg-query >/dev/null; then
    missing=$(missing_packages $packages)
    drop_unavailable
  elif [ ! -d "$build" ]; then
    say "this system has no dpkg; please make sure of the equivalents of: ${packages//\?/}"
  fi
  venv_is_ready || want_venv=1
  [ -z "$missing" ] && [ $want_venv = 0 ] && return 0
  say_what_is_missing
  ask_for_consent
  [ -z "$missing" ] || install_packages
  [ $want_venv = 0 ] || make_venv
}

say_what_is_missing() {
  [ -z "$missing" ] || say "these packages are missing: ${missing//\?/}"
  [ $want_venv = 0 ] || say "these Python packages go to build/venv: $(wanted_python)"
}

wanted_python() {
  local set files=()
  for set in $(venv_sets); do files+=("$project/toolchain/requirements/$set.txt"); done
  sed -n 's/^\([^#=]*==[^ ]*\).*/\1/p' "${files[@]}" | tr '\n' ' '
}

apt_line() { echo "${1:+$1 }apt-get update && ${1:+$1 }apt-get install -y --no-install-recommends ${missing//\?/}"; }

# Sets `as` to how root is reached: nothing to put in front, or sudo.
ask_for_consent() {
  as=()
  if [ -n "$missing" ] && [ "$(id -u)" != 0 ]; then
    if ! type -P sudo >/dev/null; then
      say "installing packages needs root. As root, run this line, then start again:"
      printf '  %s\n' "$(apt_line)"
      exit $exit_missing
    fi
    as=(sudo)
    [ $yes = 1 ] && as=(sudo -n)
  fi
  [ $yes = 1 ] && return 0
  if [ -t 0 ]; then
    local answer
    read -r -p "voltlap: install them now${missing:+ with ${as[*]:+${as[*]} }apt-get}? [Y/n] " answer
    [[ "$answer" =~ ^[nN] ]] || return 0
  fi
  say "nothing was installed. Start again with --yes to have it done${missing:+, or run this line}."
  [ -z "$missing" ] || printf '  %s\n' "$(apt_line "${as[*]:+sudo}")"
  exit $exit_missing
}

likely_cause() { if disk_is_full "$1"; then echo 'The disk is full.'; else echo 'Is the network there?'; fi; }

apt_get() { "${as[@]}" env DEBIAN_FRONTEND=noninteractive apt-get "$@" -q -o DPkg::Lock::Timeout=300 >>"$log" 2>&1; }

update_and_install() {
  apt_get update || return
  drop_unavailable
  [ -z "$missing" ] || apt_get install -y --no-install-recommends ${missing//\?/}
}

install_packages() {
  local log="$project/build/apt.log"
  : >"$log"
  # The question for the password comes before the seconds count.
  if [ "${as[*]}" = sudo ]; then sudo -v; fi
  if ! with_ticker "installing packages; this can take some minutes" update_and_install; then
    tail -n 15 "$log" >&2
    say "the packages could not be installed (whole log: $log). $(likely_cause "$log") This line does it by hand:"
    printf '  %s\n' "$(apt_line "${as[*]:+sudo}")"
    exit $exit_missing
  fi
}

fill_venv() {
  local log=$1
  shift
  [ ! -L "$venv" ] || rm "$venv"  # --clear would empty what the link leads to: another project's environment
  { "$(base_python)" -m venv --clear "$venv" &&
    "$venv/bin/python" -m pip install --disable-pip-version-check -q "$@"; } >"$log" 2>&1
}

make_venv() {
  local log="$project/build/venv.log" set files=()
  for set in $(venv_sets); do files+=(-r "$project/toolchain/requirements/$set.txt"); done
  local recipe
  recipe=$(venv_recipe $(venv_sets))
  if ! with_ticker "setting up Python packages in build/venv" fill_venv "$log" "${files[@]}"; then
    tail -n 15 "$log" >&2
    say "the Python packages could not be installed (whole log: $log). $(likely_cause "$log")"
    say "Without them, give codecs generated ahead: cmake --preset default -DVOLTLAP_CODECS=DIR."
    exit $exit_missing
  fi
  printf '%s\n' "$recipe" >"$venv_record"
}
