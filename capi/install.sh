#!/bin/sh
# Installs the C library under a prefix: header, shared and static library, and what pkg-config, CMake and Fortran find them by.
#
#   sh capi/install.sh --prefix /usr/local
#
# Needs cargo and what POSIX calls utilities. The installed folders may be moved together: no file names the prefix.
set -eu

usage() {
  cat <<'END'
sh capi/install.sh --prefix DIR [--libdir NAME] [--target TRIPLE] [--profile NAME] [--built DIR]

  --prefix DIR      where to install: DIR/include, DIR/lib, DIR/share; DESTDIR, if it is set, goes before it
  --libdir NAME     folder of the libraries below the prefix, such as lib64 or lib/x86_64-linux-gnu [lib]
  --target TRIPLE   for another machine, as cargo names it [this one]
  --profile NAME    profile of cargo [release]
  --built DIR       takes the libraries of this folder, such as target/debug, and compiles nothing; Linux only
END
}

fail() {
  echo "install.sh: $1" >&2
  exit 1
}

prefix='' libdir=lib target='' profile=release built=''
while [ $# -gt 0 ]; do
  case $1 in
    --help | -h) usage && exit ;;
    --prefix | --libdir | --target | --profile | --built)
      [ $# -gt 1 ] || fail "$1 needs a value; see --help"
      case $1 in
        --prefix) prefix=$2 ;;
        --libdir) libdir=$2 ;;
        --target) target=$2 ;;
        --profile) profile=$2 ;;
        --built) built=$2 ;;
      esac
      shift 2
      ;;
    *) fail "there is no argument $1; see --help" ;;
  esac
done
[ -n "$prefix" ] || fail 'say where to install: --prefix DIR; see --help'
case /$libdir/ in
  //* | */../* | */./*) fail "--libdir $libdir is not the name of a folder below the prefix" ;;
esac
case $prefix in
  /* | [A-Za-z]:*) ;;
  *) prefix=$PWD/$prefix ;;
esac

capi=$(CDPATH='' cd -- "$(dirname -- "$0")" && pwd)
version=$(sed -n 's/^version = "\(.*\)"$/\1/p' "$capi/../Cargo.toml")
[ "$version" ] || fail "$capi/../Cargo.toml has no version"
# before 1.0 a minor version may change the interface
interface=${version%.*}
[ -n "$target" ] && triple=$target || triple=$(rustc -vV | sed -n 's/^host: //p')

# prints "native-static-libs: ..." among other lines
said=$(mktemp)
trap 'rm -f "$said"' EXIT
if [ -n "$built" ]; then
  case $triple in
    *-linux-*) ;;
    *) fail '--built is for Linux: elsewhere only the build itself knows what the static library needs' ;;
  esac
  # what the standard library needs, which on Linux is all
  echo | rustc --crate-type staticlib --print native-static-libs -o "$said.a" - 2>"$said" || fail "$(cat "$said")"
  rm -f "$said.a"
else
  cd "$capi"
  set -- --package hexcast-c --lib --profile "$profile" --locked ${target:+--target "$target"}
  # cargo says again what is wanted where nothing is left to compile
  {
    cargo rustc "$@" --color never -- --print native-static-libs 2>&1 || echo 'install.sh: cargo failed'
  } | tee "$said" >&2
  ! grep -q '^install.sh: cargo failed$' "$said" || exit 1
  folder=$(cargo metadata --format-version 1 --no-deps | sed -e 's/.*"target_directory":"\([^"]*\)".*/\1/' -e 's,\\\\,/,g')
  [ "$profile" = dev ] && profile=debug
  built=$folder${target:+/$target}/$profile
fi
needs=$(sed -n 's/^.*native-static-libs: *//p' "$said" | tail -n 1)

# names of files: what linkers look for, and what programs find when they run
case $triple in
  *-windows-msvc)
    shared=bin/hexcast.dll static=$libdir/hexcast_static.lib import=$libdir/hexcast.lib soname=''
    built_shared=hexcast.dll built_static=hexcast.lib built_import=hexcast.dll.lib
    ;;
  *-windows-*)
    shared=bin/hexcast.dll static=$libdir/libhexcast.a import=$libdir/libhexcast.dll.a soname=''
    built_shared=hexcast.dll built_static=libhexcast.a built_import=libhexcast.dll.a
    ;;
  *-apple-*)
    shared=$libdir/libhexcast.$version.dylib static=$libdir/libhexcast.a import='' soname=libhexcast.$interface.dylib
    links="$soname libhexcast.dylib" built_shared=libhexcast.dylib built_static=libhexcast.a
    ;;
  *)
    shared=$libdir/libhexcast.so.$version static=$libdir/libhexcast.a import='' soname=libhexcast.so.$interface
    links="$soname libhexcast.so" built_shared=libhexcast.so built_static=libhexcast.a
    ;;
esac
for file in "$built_shared" "$built_static"; do
  [ -f "$built/$file" ] || fail "there is no $built/$file: the library was not built, or elsewhere"
done

root=${DESTDIR:-}$prefix
put() {
  mkdir -p "$(dirname -- "$root/$2")"
  # a library that a program has loaded keeps its bytes
  rm -f "$root/$2"
  cp "$1" "$root/$2"
  chmod "$3" "$root/$2"
  echo "$root/$2"
}

put "$capi/include/hexcast.h" include/hexcast.h 644
put "$capi/fortran/hexcast.f90" share/hexcast/hexcast.f90 644
put "$built/$built_shared" "$shared" 755
put "$built/$built_static" "$static" 644
[ -z "$import" ] || put "$built/$built_import" "$import" 644
for link in ${links:-}; do
  ln -sf "$(basename -- "$shared")" "$root/$libdir/$link"
  echo "$root/$libdir/$link"
done

# the way from a file in LIBDIR/pkgconfig or LIBDIR/cmake/hexcast up to the prefix
up=$(echo "$libdir" | sed 's,[^/][^/]*,..,g')
case $triple in
  *-windows-msvc) listed=$(echo "$needs" | sed 's/  */;/g') ;;
  # "-framework Metal" is one
  *) listed=$(echo "$needs" | sed 's/  *-/;-/g') ;;
esac
fill() {
  sed -e "s,@VERSION@,$version,g" -e "s,@LIBDIR@,$libdir,g" -e "s,@UP@,$up,g" -e "s,@SHARED@,$shared,g" \
    -e "s,@STATIC@,$static,g" -e "s,@IMPORT@,$import,g" -e "s,@SONAME@,$soname,g" -e "s,@NEEDS@,$needs,g" -e "s,@LISTED@,$listed,g" \
    "$capi/install/$1.in" >"$said"
  put "$said" "$2" 644
}
fill hexcast.pc "$libdir/pkgconfig/hexcast.pc"
fill hexcast-config.cmake "$libdir/cmake/hexcast/hexcast-config.cmake"
fill hexcast-config-version.cmake "$libdir/cmake/hexcast/hexcast-config-version.cmake"
