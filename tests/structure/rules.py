# SPDX-License-Identifier: Apache-2.0
"""The rules of the source tree, each at one place, and the functions that find what breaks them.

Every `check_*` function takes the root of a source tree (or what a tool printed) and returns a list of complaints.
"""

import pathlib
import re

# Which modules each module may include. `core` stands on the standard library and Eigen alone.
ARROWS = {
    "core": set(),
    "kernels": set(),
    "filter": {"core", "kernels"},
    "sac": {"core", "kernels"},
    "planes": {"core", "kernels", "filter", "sac"},
    "obstacles": {"core", "kernels", "filter", "planes"},
    "track": {"core", "planes", "obstacles"},
    "calibrate": {"core", "planes"},
    "eval": {"core"},
    "synth": {"core"},
    "io": {"core"},
    # The one-line façade over segmentation.
    "facade": {"core", "planes"},
    # Programs and bindings know public headers only, whichever they like.
    "python": {"core", "filter", "sac", "planes", "obstacles", "track", "calibrate", "eval", "synth", "io", "facade"},
    "apps": {"core", "filter", "sac", "planes", "obstacles", "track", "calibrate", "eval", "synth", "io", "facade"},
    # So do adapters; their headers stand under include/ of their own.
    "adapters": {"core", "filter", "sac", "planes"},
}

# Which headers from outside the project a module may include, by the first part of the path. The standard library and
# Eigen are for all but the kernels, which know raw pointers only.
OUTSIDE = {
    "core": {"tbb", "pthread.h"},
    "kernels": {"hwy"},
    "io": {"nlohmann", "libdeflate.h", "spng.h", "tiffio.h", "turbojpeg.h", "yaml-cpp", "dirent.h", "fcntl.h", "sys", "unistd.h"},
    "adapters": {"pcl"},
    "apps": {"CLI", "fmt", "nlohmann", "fcntl.h", "sys", "unistd.h"},
    "python": {"nanobind"},
}
OUTSIDE_PUBLIC_HEADERS = {"Eigen"}

# Only this file makes threads; everybody else calls parallel_for.
THREAD_MAKER = "src/core/parallel.cc"
THREAD_HEADERS = {"thread", "future", "execution", "omp.h", "pthread.h", "tbb"}

# Files of a module that live in another one's folder.
RESIDENTS = {
    "include/fransac/fransac.hpp": "facade",
    "include/fransac/version.hpp": "facade",
    "include/fransac/version.hpp.in": "facade",
}

# Where functions that must not throw are called with failing allocations, and what their declarations look like.
FAILURES_TEST = "tests/allocations/failures_test.cc"
FALLIBLE = re.compile(r"^ *(?:Status|Result<.+>) (\w+)\(", re.MULTILINE)

SOURCE_SUFFIXES = {".hpp", ".h", ".cc", ".cpp", ".in"}
SPDX = "SPDX-License-Identifier: Apache-2.0"
SPDX_SUFFIXES = SOURCE_SUFFIXES | {".py", ".cmake", ".sh"}
SPDX_NAMES = {"CMakeLists.txt"}
FOLDERS = ("include", "src", "apps", "adapters", "bench", "cmake", "examples", "fuzz", "python", "scripts", "tests", "test_package", ".ci")

# What a library must not call: it would print, or end the program of its user. Demangled names as `nm -C` prints them.
FORBIDDEN_SYMBOLS = re.compile(
    r"""^(?:
        v?f?printf | v?dprintf | __v?f?printf_chk | f?puts | f?putc | putchar | perror | syslog |
        abort | exit | _exit | _Exit | quick_exit | __assert_fail | raise |
        std::terminate\(\) | std::abort\(\) | std::exit\(int\) |
        std::(?:cout|cerr|clog|cin) | (?:std::)?(?:stdout|stderr) |
        hwy::Abort\(.* | pcl::console::print.*
    )(?:@.*)?$""",
    re.VERBOSE,
)

# Sources of randomness and time that a rerun does not repeat.
UNREPEATABLE = re.compile(
    r"\brandom_device\b|\bsrand\s*\(|(?<![\w:.>])rand\s*\(\s*\)|\btime\s*\(\s*(?:NULL|nullptr|0|&)|\bsystem_clock\b|\bgettimeofday\b"
)

LINK = re.compile(r"\]\((?![a-z]+:)([^)#\s]*)(?:#([^)\s]+))?\)")
CODE = re.compile(r"```.*?```|`[^`\n]*`", re.DOTALL)
INCLUDE = re.compile(r"^\s*#\s*include\s*([<\"])([^>\"]+)[>\"]", re.MULTILINE)
COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)


def files(root, folders=FOLDERS):
    """All files of the tree's folders, as paths relative to its root."""
    root = pathlib.Path(root)
    return sorted(
        path.relative_to(root).as_posix()
        for folder in folders
        for path in (root / folder).rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    )


def read(root, path):
    return (pathlib.Path(root) / path).read_text(encoding="utf-8")


def module_of(path):
    """The module that a file of include/, src/ or apps/ belongs to."""
    if path in RESIDENTS:
        return RESIDENTS[path]
    parts = path.split("/")
    if parts[0] == "include":
        return parts[2]
    return parts[1] if parts[0] == "src" else parts[0]


def resolve(root, path, name):
    """The file of the tree that `#include "name"` in `path` means, or None."""
    beside = (pathlib.PurePosixPath(path).parent / name).as_posix()
    for candidate in ("include/" + name, "adapters/pcl/include/" + name, "include/" + name + ".in", "src/" + name, beside):
        if (pathlib.Path(root) / candidate).is_file():
            return candidate
    return None


def check_includes(root):
    complaints = []
    for path in files(root, ("include", "src", "apps", "adapters", "python")):
        if pathlib.PurePosixPath(path).suffix not in SOURCE_SUFFIXES:
            continue
        module = module_of(path)
        if module not in ARROWS:
            complaints.append(f"{path}: module '{module}' is not in the table of arrows")
            continue
        for bracket, name in INCLUDE.findall(read(root, path)):
            target = None if bracket == "<" else resolve(root, path, name)
            complaint = inside_complaint(path, module, name, target) if target else outside_complaint(path, module, name)
            if complaint:
                complaints.append(f"{path}: {complaint}")
    return complaints


def outside_complaint(path, module, name):
    first = name.split("/")[0]
    if name.startswith("fransac/"):
        return f"writes <{name}>; the project's own headers stand in quotes"
    if first in THREAD_HEADERS and module != "apps" and path != THREAD_MAKER:
        return f"includes {name}; only {THREAD_MAKER} makes threads"
    if "/" not in name and "." not in name:
        return None  # the standard library
    if path.startswith("include/"):
        allowed = OUTSIDE_PUBLIC_HEADERS
    else:
        allowed = OUTSIDE.get(module, set()) | (set() if module == "kernels" else {"Eigen"})
    if first not in allowed:
        return f"includes {name}, which is not for {'public headers' if path.startswith('include/') else module}"
    return None


def inside_complaint(path, module, name, target):
    other = module_of(target)
    public = target.startswith("include/")
    if path.startswith("include/") and not public:
        return f'is public and includes the private "{name}"'
    if module in ("apps", "adapters", "python") and not public and other != module:
        return f'is outside the library and includes the private "{name}"'
    if other != module and other not in ARROWS[module]:
        return f'includes "{name}": no arrow leads from {module} to {other}'
    return None


def check_spdx(root):
    complaints = []
    for path in files(root):
        pure = pathlib.PurePosixPath(path)
        script = pure.suffix == "" and path.split("/")[0] in ("scripts", ".ci")
        if not (pure.suffix in SPDX_SUFFIXES or pure.name in SPDX_NAMES or script):
            continue
        if not any(SPDX in line for line in read(root, path).splitlines()[:2]):
            complaints.append(f"{path}: no '{SPDX}' in the first two lines")
    return complaints


def version_of(root):
    """The version in CMakeLists.txt's project()."""
    return re.search(r"project\(fransac VERSION (\d+\.\d+\.\d+)", read(root, "CMakeLists.txt")).group(1)


def check_version(root):
    """The full version stands in project() and nowhere else in code."""
    literal = re.compile(r"(?<![\d.])" + re.escape(version_of(root)) + r"(?![\d.])")
    suffixes = SPDX_SUFFIXES | {".txt", ".json"}
    paths = [p for p in files(root) if pathlib.PurePosixPath(p).suffix in suffixes] + ["CMakePresets.json"]
    return [f"{path}: repeats the version" for path in paths if literal.search(read(root, path))]


def check_citation(root):
    """CITATION.cff names the version of project()."""
    cited = re.search(r"^version: (\S+)$", read(root, "CITATION.cff"), re.MULTILINE)
    if cited and cited.group(1) == version_of(root):
        return []
    return [f"CITATION.cff: version is not {version_of(root)}"]


def anchors(text):
    """What a link can jump to in a page: its headings, as the pages' hosts spell them."""
    headings = re.findall(r"^#+ (.+)$", text, re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def check_links(root):
    """Links of Markdown pages to files and headings of this tree."""
    root = pathlib.Path(root)
    complaints = []
    for page in [*root.glob("*.md"), *root.glob("docs/**/*.md")]:
        # The site has these at its root.
        folder = root if page.parent == root / "docs/site" else page.parent
        for target, anchor in LINK.findall(CODE.sub("", page.read_text(encoding="utf-8"))):
            file = folder / target if target else page
            if not file.exists():
                complaints.append(f"{page.relative_to(root)}: no file {target}")
            elif anchor and file.suffix == ".md" and anchor not in anchors(file.read_text(encoding="utf-8")):
                complaints.append(f"{page.relative_to(root)}: no heading #{anchor} in {file.name}")
    return complaints


def check_repeatable(root):
    complaints = []
    for path in files(root, ("include", "src", "apps", "adapters", "python", "bench", "tests", "fuzz")):
        if pathlib.PurePosixPath(path).suffix not in SOURCE_SUFFIXES:
            continue
        for match in UNREPEATABLE.finditer(COMMENT.sub("", read(root, path))):
            complaints.append(f"{path}: '{match.group(0)}' makes a run unrepeatable")
    return complaints


def check_failures_tested(root):
    """Every public function that returns a Result or a Status is called with failing allocations."""
    tested = read(root, FAILURES_TEST)
    complaints = []
    for path in files(root, ("include",)):
        for name in FALLIBLE.findall(read(root, path)):
            if not re.search(rf"\b{name}\(", tested):
                complaints.append(f"{path}: {name}() is not in {FAILURES_TEST}")
    return complaints


def check_symbols(nm_output):
    """What `nm -C --undefined-only` printed for a library."""
    complaints = []
    member = ""
    for line in nm_output.splitlines():
        if line.endswith(":"):
            member = line[:-1]
            continue
        name = line.strip().removeprefix("U ").strip()
        if FORBIDDEN_SYMBOLS.match(name):
            complaints.append(f"{member}: calls {name}")
    return complaints
