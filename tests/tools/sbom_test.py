"""tools/sbom against other sources: the dynamic section of the program, and the lock of npm."""

import json
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]


def write(program, file):
    subprocess.run([sys.executable, "-B", ROOT / "tools/sbom", program, "-o", file], check=True)
    return file.read_bytes()


def needed(program):
    """Names of the libraries that the program itself asks for."""
    told = subprocess.run(["readelf", "-d", program], capture_output=True, text=True, check=True).stdout
    return [line.split("[")[1].split("]")[0] for line in told.splitlines() if "(NEEDED)" in line]


def holders(library):
    """The packages with a library of this name, by the lists of their files instead of dpkg's search."""
    return {listed.name.removesuffix(".list").split(":")[0]
            for listed in pathlib.Path("/var/lib/dpkg/info").glob("*.list")
            if f"/{library}\n" in listed.read_text(encoding="utf-8")}


def main():
    program = pathlib.Path(sys.argv[1])
    with tempfile.TemporaryDirectory() as folder:
        first = write(program, pathlib.Path(folder) / "a.json")
        assert first == write(program, pathlib.Path(folder) / "b.json"), "two runs differ"
    found = json.loads(first)
    assert (found["bomFormat"], found["specVersion"]) == ("CycloneDX", "1.5")
    parts = {one["name"]: one for one in found["components"]}
    assert len(parts) == len(found["components"]), "a part is there twice"
    libraries = needed(program)
    assert len(libraries) > 5
    for library in libraries:
        packages = holders(library)
        # Alternatives, as BLAS is one, belong to no package by that name.
        assert not packages or packages & set(parts), f"{library} of {packages} is missing"
    assert "g++" in parts and "libeigen3-dev" in parts and "cmake" not in parts
    assert parts["g++"]["purl"].startswith("pkg:deb/debian/g%2B%2B@")
    lock = json.loads((ROOT / "tools/web/package-lock.json").read_text(encoding="utf-8"))["packages"]
    bundled = {name for name in lock[""]["dependencies"]}
    assert bundled <= set(parts)
    assert all(len(parts[name]["hashes"][0]["content"]) == 128 for name in bundled), "of SHA-512"
    references = {one["bom-ref"] for one in found["components"]}
    assert set(found["dependencies"][0]["dependsOn"]) == references
    print(f"sbom: {len(parts)} parts, {len(libraries)} libraries that the program asks for")


if __name__ == "__main__":
    main()
