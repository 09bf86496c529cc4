#!/bin/sh
# Looks for EGL, which draws without a screen, before anything large is installed.
# As root on Debian or Ubuntu (a container, continuous integration) it installs the library and says so; for
# anyone else it names the one line to run. Where it cannot tell, `geoweave doctor` finds out later.
set -eu

PACKAGES="libegl1 libgl1-mesa-dri"

[ "$(uname -s)" = Linux ] || exit 0
# Debian keeps ldconfig where only root looks for programs.
PATH="$PATH:/sbin:/usr/sbin"
command -v ldconfig >/dev/null || exit 0
case "$(ldconfig -p)" in *libEGL.so.1*) exit 0 ;; esac

if ! command -v apt-get >/dev/null; then
  echo "geoweave: drawing without a screen needs the library libEGL.so.1 of Mesa; install it and run make again" >&2
  exit 1
fi
if [ "$(id -u)" != 0 ]; then
  echo "geoweave: drawing without a screen needs a library; run: sudo apt-get install $PACKAGES" >&2
  exit 1
fi
echo "geoweave: drawing without a screen needs a library; installing $PACKAGES" >&2
apt-get update
# shellcheck disable=SC2086
DEBIAN_FRONTEND=noninteractive apt-get install --yes --no-install-recommends $PACKAGES
