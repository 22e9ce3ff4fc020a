"""Archives with the same bytes for the same files: members in order, one time, no names of users.

    python archive.py pack FOLDER FILE SECONDS   makes FILE, a .tar.gz or .zip, of FOLDER
    python archive.py unpack FILE FOLDER
    python archive.py differ FILE OTHER          prints the members that differ, of archives of these kinds, wheels and crates, too
"""

import gzip
import hashlib
import sys
import tarfile
import time
import zipfile
from pathlib import Path


def members(folder):
    """Files and links below a folder, in order of their names, with those in the archive."""
    paths = sorted(path for path in folder.rglob("*") if path.is_symlink() or path.is_file())
    return [(path, path.relative_to(folder.parent).as_posix()) for path in paths]


def pack_tar(folder, file, seconds):
    def plain(member):
        member.uid = member.gid = 0
        member.uname = member.gname = ""
        member.mtime = seconds
        member.mode = 0o755 if member.mode & 0o100 else 0o644
        return member

    with open(file, "wb") as raw, gzip.GzipFile("", "wb", 9, raw, mtime=0) as compressed:
        with tarfile.open(fileobj=compressed, mode="w", format=tarfile.GNU_FORMAT) as archive:
            for path, name in members(folder):
                archive.add(path, name, recursive=False, filter=plain)


def pack_zip(folder, file, seconds):
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for path, name in members(folder):
            member = zipfile.ZipInfo(name, time.gmtime(seconds)[:6])
            member.external_attr = (0o755 if path.suffix in (".exe", ".dll") else 0o644) << 16
            member.create_system = 3
            archive.writestr(member, path.read_bytes(), zipfile.ZIP_DEFLATED)


def unpack(file, folder):
    if file.suffix in (".zip", ".whl"):
        with zipfile.ZipFile(file) as archive:
            archive.extractall(folder)
    else:
        with tarfile.open(file) as archive:
            archive.extractall(folder, filter="tar")


def hashes(file):
    """SHA-256 of the members of an archive, by their names; of what is none, of the file itself."""
    of = lambda data: hashlib.sha256(data).hexdigest()
    if zipfile.is_zipfile(file):
        with zipfile.ZipFile(file) as archive:
            return {name: of(archive.read(name)) for name in archive.namelist()}
    if not tarfile.is_tarfile(file):
        return {file.name: of(file.read_bytes())}
    with tarfile.open(file) as archive:
        return {member.name: member.linkname or of(archive.extractfile(member).read()) for member in archive if not member.isdir()}


def differ(one, other):
    first, second = hashes(one), hashes(other)
    return sorted(name for name in {*first, *second} if first.get(name) != second.get(name))


if __name__ == "__main__":
    what, one, other, *more = sys.argv[1:]
    if what == "pack":
        (pack_zip if other.endswith(".zip") else pack_tar)(Path(one), other, int(more[0]))
    elif what == "unpack":
        unpack(Path(one), Path(other))
    elif what == "differ":
        print("\n".join(differ(Path(one), Path(other))))
    else:
        sys.exit(__doc__)
