#!/bin/bash
# Usage: fetch_unity.sh FOLDER
# Puts the sources of Unity (the C test framework) into FOLDER from Debian's source package ntpsec, which carries it: for
# machines that reach Debian's archive but not Unity's own repository. Needs no root: package lists and cache are its own, in
# a temporary folder, and the archive's address is the one that this machine's apt already uses.
set -euo pipefail

package=ntpsec
target=${1:?usage: fetch_unity.sh FOLDER}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# The machine's own entries, binary packages turned into source packages, in both of apt's formats.
write_source_lists() {
  mkdir -p "$work/sources"
  local file
  for file in /etc/apt/sources.list.d/*.sources; do
    [ -e "$file" ] || continue
    sed -E 's/^Types:.*/Types: deb-src/' "$file"
    echo
  done > "$work/sources/machine.sources"
  for file in /etc/apt/sources.list /etc/apt/sources.list.d/*.list; do
    [ -e "$file" ] || continue
    sed -nE 's/^deb /deb-src /p' "$file"
  done > "$work/sources/machine.list"
}

apt_here() {
  apt-get -qq -o Dir::Etc::sourcelist=/dev/null -o Dir::Etc::sourceparts="$work/sources" \
    -o Dir::State::lists="$work/lists" -o Dir::Cache="$work/cache" -o APT::Sandbox::User="$(id -un)" \
    -o Acquire::Retries=3 "$@"
}

write_source_lists
mkdir -p "$work/lists/partial" "$work/cache/archives/partial" "$work/package" "$work/unity"
apt_here update
(cd "$work/package" && apt_here source --download-only "$package" > /dev/null)
tar -xf "$work/package/${package}"_*.orig.tar.xz -C "$work/unity" --strip-components=3 --wildcards '*/tests/unity/unity*'

[ -s "$work/unity/unity.c" ] || { echo "fetch_unity.sh: the package $package holds no unity.c" >&2; exit 1; }
mkdir -p "$(dirname "$target")"
rm -rf "$target"
mv "$work/unity" "$target"
echo "Unity: from Debian's source package $package, in $target"
