"""The thesis-scale campaign: made once by lipoid, read by lipoid and by its peer.

Table 4.8 with a branch of 30 s that can be seen, 10 ms sampling, 0.2 mV of noise, 10 uV of
resolution. More noise would not be fair: the peer joins 5,000 raw rows of the low rate to its curve,
and with 1 mV on each its differences stumble from one row to the next and may not end at all. The
header is the peer's, time_s,current_a,voltage_v (lipoid does not mind), and the peer's names of the
files are links: both read the same bytes.
"""

from .process import ROOT, run, say

BRANCH = {"r_1": 0.0005, "c_1": 60000}
NOISE_V = 0.0002
HEADER = b"time_s,current_A,voltage_V\n"
PEER_HEADER = HEADER.lower()


def make(lipoid, folder, sampling_s, branch=None, noise_V=NOISE_V):
    """{"command", "folder", "files", "bytes", "rows"}; made anew where another one is there."""
    parameters = ",".join(f"{name}={value}" for name, value in (branch or BRANCH).items())
    command = [lipoid, "synthesize", "grepow-32Ah-1", "--with", parameters,
               "--rates-C", "1,2,3,4,5,6,7,8", "--voltage-noise-V", str(noise_V),
               "--voltage-resolution-V", "0.00001", "--seed", "1"]
    if sampling_s != 0.01:
        command += ["--sampling-s", str(sampling_s)]
    command += ["-o", folder]
    stamp = folder / "made_by.txt"
    text = " ".join(str(word) for word in command[1:])
    if not stamp.is_file() or stamp.read_text(encoding="utf-8") != text:
        say("making the campaign")
        run(command)
        for file in sorted(folder.glob("*.csv")):
            write_peer_header(file)
        link_peer_names(folder)
        stamp.write_text(text, encoding="utf-8")
    place = str(folder.relative_to(ROOT))
    files = [describe(file) for file in sorted(folder.glob("*.csv"))]
    return {
        "command": "lipoid " + text.replace(str(folder), place),
        "folder": place,
        "files": files,
        "bytes": sum(file["bytes"] for file in files),
        "rows": sum(file["rows"] for file in files),
    }


def write_peer_header(file):
    """The same letters in lower case: not a byte moves."""
    with open(file, "r+b") as stream:
        if stream.read(len(HEADER)) in (HEADER, PEER_HEADER):
            stream.seek(0)
            stream.write(PEER_HEADER)
        else:
            raise ValueError(f"{file}: expected the header {HEADER!r}")


def peer_folder(folder):
    return folder / "peer"


def link_peer_names(folder):
    links = peer_folder(folder)
    links.mkdir(exist_ok=True)
    for file in sorted(folder.glob("*.csv")):
        link = links / ("pulse.csv" if file.name == "pulses.csv" else file.name)
        link.unlink(missing_ok=True)
        link.symlink_to(f"../{file.name}")


def describe(file):
    with open(file, "rb") as stream:
        rows = sum(block.count(b"\n") for block in iter(lambda: stream.read(1 << 22), b"")) - 1
    return {"file": file.name, "bytes": file.stat().st_size, "rows": rows}
