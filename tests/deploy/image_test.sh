#!/usr/bin/env bash
# Builds curvd:latest with buildah and runs it with podman as deploy/ asks: image_test.sh. Says why it does not, and ends
# with 0, where the programs for it are missing. Pulls nothing: the base image is made of Debian's packages, once.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

skip() { echo "image-test: skipped: $*"; exit 0; }
[ "$(id -u)" = 0 ] || skip "podman must see the containers' control groups, which takes root"
for program in buildah podman runc catatonit mmdebstrap openssl; do
  command -v "$program" >/dev/null || skip "no $program (apt-get install buildah podman runc catatonit mmdebstrap openssl)"
done

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
# Without systemd there is nobody else to make control groups, and limits above these may not be ours to give.
if [ ! -d /run/systemd/system ] && [ -z "${CONTAINERS_CONF:-}" ]; then
  export CONTAINERS_CONF=$scratch/containers.conf
  printf '%s\n' '[containers]' 'default_ulimits = ["nofile=20000:20000", "nproc=4096:4096"]' \
    '[engine]' 'runtime = "runc"' 'cgroup_manager = "cgroupfs"' 'events_logger = "file"' >"$CONTAINERS_CONF"
fi

base=docker.io/library/debian:bookworm-slim
if ! podman image exists "$base"; then
  mmdebstrap --quiet --variant=minbase bookworm "$scratch/root.tar"
  podman import --quiet "$scratch/root.tar" "$base" >/dev/null
fi
make image CONTAINER_TOOL=buildah IMAGE_FLAGS="--pull-never --isolation=chroot --layers ${IMAGE_FLAGS:-}"
/usr/bin/python3 tests/deploy/image_test.py .
