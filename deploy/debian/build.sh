#!/usr/bin/env bash
# Makes Debian packages of what a build made: build.sh BUILD_DIR OUTPUT_DIR
#
# curvd is the server as a service, curv the command line, libcurvd-client-dev the C++ client. Each package is a component of
# cmake/install.cmake and, beside it here, what stands in its .control file, its maintainer scripts and its configuration.
# DEBFULLNAME and DEBEMAIL name the maintainer, SOURCE_DATE_EPOCH the time of the files: the same build gives the same bytes.
set -euo pipefail

build_dir=$(realpath "$1")
mkdir -p "$2"
output_dir=$(realpath "$2")
here=$(realpath "$(dirname "${BASH_SOURCE[0]}")")
source_dir=$(realpath "$here/../..")
maintainer="${DEBFULLNAME:-The curvd authors} <${DEBEMAIL:-curvd@curvd.invalid}>"
# What a build leaves in its cache.
cached() { sed -n "s/^$1:[A-Z]*=//p" "$build_dir/CMakeCache.txt"; }
version=$(cached CMAKE_PROJECT_VERSION)
architecture=$(dpkg --print-architecture)
if [ -z "${SOURCE_DATE_EPOCH:-}" ]; then
  SOURCE_DATE_EPOCH=$(git -C "$source_dir" log -1 --format=%ct 2>/dev/null || date +%s)
fi
export SOURCE_DATE_EPOCH

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
umask 022

# add_documents ROOT PACKAGE: what Debian's policy asks of each package.
add_documents() {
  local folder=$1/usr/share/doc/$2
  install -D --mode=644 "$here/copyright" "$folder/copyright"
  printf 'curvd (%s) unstable; urgency=medium\n\n  * What changed is told in NEWS.gz.\n\n -- %s  %s\n' "$version" "$maintainer" \
    "$(date --utc --rfc-email --date="@$SOURCE_DATE_EPOCH")" | gzip -9n >"$folder/changelog.gz"
  gzip -9nc "$source_dir/CHANGELOG.md" >"$folder/NEWS.gz"
  if [ -f "$here/$2.lintian-overrides" ]; then
    install -D --mode=644 "$here/$2.lintian-overrides" "$1/usr/share/lintian/overrides/$2"
  fi
}

# add_man_page ROOT PROGRAM SECTION WHATIS
add_man_page() {
  mkdir -p "$1/usr/share/man/man$3"
  /usr/bin/python3 "$here/man_page.py" "$1/usr/bin/$2" "$3" "$4" | gzip -9n >"$1/usr/share/man/man$3/$2.$3.gz"
}

# What a service needs besides its program.
add_curvd() {
  install -D --mode=644 "$source_dir/deploy/systemd/curvd.service" "$1/lib/systemd/system/curvd.service"
  install -D --mode=644 "$here/curvd.default" "$1/etc/default/curvd"
  install -d "$1/etc/curvd"
  install -D --mode=644 --target-directory="$1/usr/share/doc/curvd" "$source_dir/docs/operations.md"
  install -D --mode=644 --target-directory="$1/usr/share/doc/curvd/examples" "$source_dir/deploy/prometheus/alerts.yml" \
    "$source_dir/deploy/grafana/curvd.json" "$source_dir/deploy/haproxy.cfg"
  add_man_page "$1" curvd 8 "curvature of point clouds over gRPC"
  echo /etc/default/curvd >"$1/DEBIAN/conffiles"
  install --mode=755 --target-directory="$1/DEBIAN" "$here"/curvd.{postinst,prerm,postrm}
  (cd "$1/DEBIAN" && for script in postinst prerm postrm; do mv "curvd.$script" "$script"; done)
}

# What shells read when somebody types curv.
add_curv() {
  add_man_page "$1" curv 1 "curvature of point clouds from the command line"
  local shells=$1/usr/share
  mkdir -p "$shells/bash-completion/completions" "$shells/zsh/vendor-completions" "$shells/fish/vendor_completions.d"
  "$1/usr/bin/curv" completion bash >"$shells/bash-completion/completions/curv"
  "$1/usr/bin/curv" completion zsh >"$shells/zsh/vendor-completions/_curv"
  "$1/usr/bin/curv" completion fish >"$shells/fish/vendor_completions.d/curv.fish"
}

# Prints the packages that hold the shared libraries of the programs below a root, with the versions that they ask for.
shared_libraries() {
  mkdir -p "$work/shlibs/debian"
  printf 'Source: curvd\n\nPackage: curvd\nArchitecture: any\n' >"$work/shlibs/debian/control"
  (cd "$work/shlibs" && dpkg-shlibdeps -O "$1"/usr/bin/* | sed -n 's/^shlibs:Depends=//p')
}

# write_control ROOT PACKAGE
write_control() {
  local depends own
  own=$(sed -n 's/^Depends: //p' "$here/$2.control")
  depends=$own
  if [ -d "$1/usr/bin" ]; then depends="$(shared_libraries "$1")${own:+, $own}"; fi
  {
    printf 'Package: %s\nSource: curvd\nVersion: %s\nArchitecture: %s\nMaintainer: %s\n' \
      "$2" "$version" "$architecture" "$maintainer"
    printf 'Installed-Size: %s\nPriority: optional\nDepends: %s\n' "$(du -sk --apparent-size "$1" | cut -f1)" "$depends"
    sed '/^Depends: /d' "$here/$2.control"
  } >"$1/DEBIAN/control"
  (cd "$1" && find . -type f ! -path './DEBIAN/*' -printf '%P\0' | sort -z | xargs -0 md5sum) >"$1/DEBIAN/md5sums"
}

# package NAME COMPONENT [COMMAND]: the command adds to the root, whose path it gets.
package() {
  local root=$work/$1
  mkdir -p "$root/DEBIAN"
  DESTDIR=$root cmake --install "$build_dir" --prefix /usr --component "$2" --strip >/dev/null
  if [ -n "${3:-}" ]; then "$3" "$root"; fi
  add_documents "$root" "$1"
  write_control "$root" "$1"
  find "$root" -newermt "@$SOURCE_DATE_EPOCH" -exec touch --no-dereference --date="@$SOURCE_DATE_EPOCH" {} +
  dpkg-deb --build --root-owner-group "$root" "$output_dir/$1_${version}_$architecture.deb" >/dev/null
  echo "$output_dir/$1_${version}_$architecture.deb"
}

package curvd curvd add_curvd
package curv curv add_curv
package libcurvd-client-dev dev
