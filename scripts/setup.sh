# SPDX-License-Identifier: Zlib
# Sourced by the other scripts: installs the Debian packages, configures and builds a preset.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

packages=(g++ cmake ninja-build pkg-config git
	libbullet-dev libbullet-extras-dev libcgal-dev libeigen3-dev libosmesa6-dev libgtest-dev
	libcli11-dev nlohmann-json3-dev libfmt-dev libpng-dev libcairo2-dev libxxhash-dev libtinygltf-dev
	fonts-dejavu-core ffmpeg gnuplot-nox)
plugin_packages=(g++ cmake ninja-build pkg-config libbullet-dev libgtest-dev libxxhash-dev)  # of scripts/test --plugin
clang_packages=(clang-16 clang-tidy-16)  # of tests only
# Of the night's tests of packages and pages, and of mutants, of which each would compile twice without the cache.
package_packages=(g++-aarch64-linux-gnu qemu-user-static dpkg-dev mmdebstrap chromium ccache mold)

say() { printf '\n== %s\n' "$*"; }

# Installs what is missing. The apt line is printed first; on a system without apt the packages are listed and we stop.
install_packages()
{
	local missing=()
	if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
		echo "This is not a Debian system. Install the equivalents of these packages, then build with"
		echo "  cmake --preset release && cmake --build --preset release"
		printf '  %s\n' "${packages[@]}"
		exit 1
	fi
	for package in "${packages[@]}"; do
		dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || missing+=("$package")
	done
	[ ${#missing[@]} -eq 0 ] && return
	local as_root=()
	[ "$(id -u)" -eq 0 ] || as_root=(sudo)
	say "Installing packages"
	echo "${as_root[*]:+sudo }apt-get install -y --no-install-recommends ${missing[*]}"
	"${as_root[@]}" apt-get update -qq
	"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
}

# build TARGET...: configures build/$build_preset and builds the targets (all without any), with $configure_options.
build()
{
	local folder=build/$build_preset
	say "Building $folder (log: $folder/build.log)"
	mkdir -p "$folder"
	cmake --preset "$build_preset" "${configure_options[@]}" >"$folder/build.log" 2>&1 || { tail -n 40 "$folder/build.log"; exit 1; }
	local targets=()
	[ $# -eq 0 ] || targets=(--target "$@")
	cmake --build --preset "$build_preset" "${targets[@]}" | tee -a "$folder/build.log" | awk -v tty="$([ -t 1 ] && echo 1)" '
		/^\[[0-9]+\/[0-9]+\]/ { split(substr($1, 2), n, "[/\\]]"); p = int(10 * n[1] / n[2]); if (tty) printf "\r  %s of %s", n[1], n[2]; else if (p != last) { printf "  %d %%\n", 10 * p; last = p }; fflush(); next }
		/error|warning|FAILED/ { print; fflush() }
		END { if (tty) printf "\n" }'
}
configure_options=(-DCLOD_BUILD_REPAIR=ON)
build_preset=release
