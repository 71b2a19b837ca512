// Who may include whom: compares every #include line of server/, render/ and client/ with the table of
// server/README.md, which is read here. A folder that is not in the table fails, so a new one has to be thought about.
// A row fails, too, if its folder is gone.

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/paths.h"

namespace {

namespace fs = std::filesystem;

struct Row {
  std::string folder;                    // files below it follow this row; the longest matching row counts
  std::vector<std::string> ours;         // folders, or single files, that may be included beside the own one
  std::vector<std::string> third_party;  // names of groups()
};

// Headers from outside, by prefix. Those that protoc makes are in two groups more, see group_of().
struct Group {
  std::string name;
  std::vector<std::string> prefixes;
};

const std::vector<Group>& groups() {
  static const std::vector<Group> all = {
      {"front doors", {"kerf/kerf.h", "kerf/client.h"}},
      {"Clipper", {"polyclipping/"}},
      {"Eigen", {"Eigen/"}},
      {"Highway", {"hwy/"}},
      {"Spectra", {"Spectra/"}},
      {"Asio", {"boost/asio", "boost/system"}},
      {"Boost", {"boost/"}},
      {"protobuf", {"google/protobuf/"}},
      {"gRPC", {"grpc/", "grpc++/", "grpcpp/"}},
      {"prometheus-cpp", {"prometheus/"}},
      {"CLI11", {"CLI/"}},
      {"nlohmann-json", {"nlohmann/"}},
      {"pugixml", {"pugixml.hpp"}},
      {"zlib", {"zlib.h"}},
      {"OpenSSL", {"openssl/"}},
      {"SQLite", {"sqlite3.h"}},
      {"OpenSSL", {"openssl/"}},
      {"minizip", {"minizip/"}},
      {"EGL", {"EGL/", "KHR/"}},
      {"OpenGL", {"GL/", "GLES"}},
      {"libpng", {"png.h"}},
      {"libjpeg-turbo", {"turbojpeg.h", "jpeglib.h"}},
      {"libvpx", {"vpx/"}},
      {"libyuv", {"libyuv/"}},
      {"POSIX",
       {"arpa/", "dirent.h", "fcntl.h", "iconv.h", "malloc.h", "netdb.h", "netinet/", "poll.h", "pthread.h", "sched.h",
        "signal.h", "spawn.h", "sys/", "termios.h", "time.h", "unistd.h"}},
  };
  return all;
}

bool starts_with(std::string_view text, std::string_view prefix) {
  return text.substr(0, prefix.size()) == prefix;
}
bool ends_with(std::string_view text, std::string_view suffix) {
  return text.size() >= suffix.size() && text.substr(text.size() - suffix.size()) == suffix;
}
std::string read(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

// Returns what stands between separators, without blanks around it.
std::vector<std::string> parts_of(std::string_view text, char separator) {
  std::vector<std::string> found;
  while (true) {
    const std::size_t end = std::min(text.find(separator), text.size());
    const std::string_view part = text.substr(0, end);
    const std::size_t first = part.find_first_not_of(' ');
    if (first != std::string_view::npos) {
      found.emplace_back(part.substr(first, part.find_last_not_of(' ') + 1 - first));
    } else {
      found.emplace_back();
    }
    if (end == text.size()) return found;
    text.remove_prefix(end + 1);
  }
}

// Returns the path of a name of the table from the repository's root. A name that means nothing, or two things, is
// returned as it is.
std::string path_of(const std::string& name) {
  std::vector<std::string> found;
  for (const std::string root : {"server/", "server/core/", "server/service/", ""}) {
    if (fs::exists(kerf::test::source_path(root + name))) found.push_back(root + name);
  }
  return found.size() == 1 ? found.front() : name;
}

std::vector<std::string> names_of(const std::string& cell) {
  return cell.empty() ? std::vector<std::string>() : parts_of(cell, ',');
}

// Returns the rows of the table below the heading "Who may include whom". A line that has not three cells becomes a row
// whose folder is the whole line.
std::vector<Row> rows_of(const std::string& page) {
  const std::string heading = "\n## Who may include whom\n";
  const std::size_t begin = std::min(page.find(heading), page.size() - heading.size()) + heading.size();
  std::vector<Row> rows;
  int num_lines = 0;
  for (const std::string& line : parts_of(page.substr(begin, page.find("\n## ", begin) - begin), '\n')) {
    if (!starts_with(line, "|") || ++num_lines <= 2) continue;  // the first two are the table's head
    const std::vector<std::string> cells = parts_of(line, '|');
    if (cells.size() != 5) {
      rows.push_back({line, {}, {}});
      continue;
    }
    Row row{path_of(cells[1]), names_of(cells[2]), names_of(cells[3])};
    std::transform(row.ours.begin(), row.ours.end(), row.ours.begin(), path_of);
    rows.push_back(std::move(row));
  }
  return rows;
}

const std::vector<Row>& table() {
  static const std::vector<Row> rows = rows_of(read(kerf::test::source_path("server/README.md")));
  return rows;
}

bool lies_in(std::string_view path, std::string_view folder) {
  return path == folder || (starts_with(path, folder) && path.size() > folder.size() && path[folder.size()] == '/');
}

struct Include {
  std::string path;
  bool quoted = false;
  int line = 0;
};

std::vector<Include> includes_of(std::string_view source) {
  std::vector<Include> found;
  int number = 0;
  for (std::size_t at = 0; at < source.size();) {
    std::size_t end = std::min(source.find('\n', at), source.size());
    std::string_view line = source.substr(at, end - at);
    at = end + 1;
    ++number;
    const auto skip_blanks = [&line] {
      while (!line.empty() && (line.front() == ' ' || line.front() == '\t')) line.remove_prefix(1);
    };
    skip_blanks();
    if (!starts_with(line, "#")) continue;
    line.remove_prefix(1);
    skip_blanks();
    if (!starts_with(line, "include")) continue;
    line.remove_prefix(7);
    skip_blanks();
    if (line.empty() || (line.front() != '<' && line.front() != '"')) continue;
    const bool quoted = line.front() == '"';
    const std::size_t close = line.find(quoted ? '"' : '>', 1);
    if (close == std::string_view::npos) continue;
    found.push_back({std::string(line.substr(1, close - 1)), quoted, number});
  }
  return found;
}

// Returns the group of a header from outside; "std" for the standard library, nothing if unknown.
std::optional<std::string> group_of(std::string_view path) {
  if (ends_with(path, ".grpc.pb.h")) return "services";
  if (ends_with(path, ".pb.h")) return "messages";
  if (path == "stddef.h" || path == "stdint.h") return "std";  // for headers that C reads, too
  for (const Group& group : groups()) {
    for (const std::string& prefix : group.prefixes) {
      if (starts_with(path, prefix)) return group.name;
    }
  }
  const bool plain = path.find('/') == std::string_view::npos && path.find('.') == std::string_view::npos;
  return plain ? std::optional<std::string>("std") : std::nullopt;
}

const Row* row_of(std::string_view file) {
  const Row* best = nullptr;
  for (const Row& row : table()) {
    if (lies_in(file, row.folder) && (best == nullptr || row.folder.size() > best->folder.size())) best = &row;
  }
  return best;
}

bool contains(const std::vector<std::string>& names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

// Returns the fault of this include, or nothing.
std::optional<std::string> fault_of(const Row& row, const Include& include) {
  const std::string& path = include.path;
  for (const std::string_view root : {"server", "render", "client", "tests"}) {
    if (!lies_in(path, root)) continue;
    if (!include.quoted) return "our own header in angle brackets";
    const Row* const room = row_of(path);
    if (room == &row) return std::nullopt;
    const bool allowed = std::any_of(row.ours.begin(), row.ours.end(), [&](const std::string& one) {
      return path == one || (room != nullptr && room->folder == one);
    });
    return allowed ? std::nullopt : std::optional<std::string>(row.folder + " may not include it");
  }
  const std::optional<std::string> group = group_of(path);
  if (!group) return "neither a path from the repository's root nor a header of a known library";
  // Boost.Asio is part of Boost.
  const bool allowed =
      *group == "std" || contains(row.third_party, *group) || (*group == "Asio" && contains(row.third_party, "Boost"));
  return allowed ? std::nullopt : std::optional<std::string>(row.folder + " may not use " + *group);
}

// Every violation in one file, as "path:line: include: why".
std::vector<std::string> violations(const std::string& file, std::string_view source) {
  const Row* row = row_of(file);
  if (row == nullptr) return {file + ": its folder is not in the include table"};
  std::vector<std::string> found;
  for (const Include& include : includes_of(source)) {
    if (const auto fault = fault_of(*row, include)) {
      found.push_back(file + ":" + std::to_string(include.line) + ": " + include.path + ": " + *fault);
    }
  }
  return found;
}

bool is_source(const fs::path& path) {
  return path.extension() == ".h" || path.extension() == ".cc" || path.extension() == ".inc";
}

TEST(IncludeTable, HoldsForEverySourceFile) {
  const fs::path root = kerf::test::source_path("");
  std::vector<std::string> found;
  int num_files = 0;
  for (const char* top : {"server", "render", "client"}) {
    for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
      if (!entry.is_regular_file() || !is_source(entry.path())) continue;
      const auto here = violations(fs::relative(entry.path(), root).generic_string(), read(entry.path()));
      found.insert(found.end(), here.begin(), here.end());
      ++num_files;
    }
  }
  EXPECT_THAT(found, testing::IsEmpty());
  EXPECT_GT(num_files, 10) << "the search found next to nothing under " << root;
}

TEST(IncludeTable, ListsOnlyWhatExists) {
  const fs::path root = kerf::test::source_path("");
  for (const Row& row : table()) {
    EXPECT_TRUE(fs::is_directory(root / row.folder)) << row.folder;
    EXPECT_EQ(row_of(row.folder), &row) << row.folder << " has two rows";
    for (const std::string& one : row.ours) EXPECT_TRUE(fs::exists(root / one)) << one << ", listed for " << row.folder;
    for (const std::string& name : row.third_party) {
      const bool known = name == "messages" || name == "services" ||
                         std::any_of(groups().begin(), groups().end(), [&](const Group& g) { return g.name == name; });
      EXPECT_TRUE(known) << name << ", listed for " << row.folder;
    }
  }
}

TEST(IncludeTable, IsReadFromThePage) {
  const std::vector<Row> rows = rows_of(
      "# Page\n\n## Who may include whom\n\nSee | this.\n\n| folder | may include | third party |\n|---|---|---|\n"
      "| fem/step | mesh, app | |\n| client/cli | wire/json.h, gone | Boost, gRPC |\n| two | cells |\n\n## To add\n\n"
      "| what | touch | |\n|---|---|---|\n| cut | base | |\n");
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[0].folder, "server/core/fem/step");
  EXPECT_THAT(rows[0].ours, testing::ElementsAre("server/core/mesh", "server/app"));
  EXPECT_THAT(rows[0].third_party, testing::IsEmpty());
  EXPECT_EQ(rows[1].folder, "client/cli");
  EXPECT_THAT(rows[1].ours, testing::ElementsAre("server/service/wire/json.h", "gone"));
  EXPECT_THAT(rows[1].third_party, testing::ElementsAre("Boost", "gRPC"));
  EXPECT_EQ(rows[2].folder, "| two | cells |");
}

// The check itself, against faults put there on purpose.
struct Seeded {
  std::string file;
  std::string line;
  bool violates;
};

TEST(IncludeTable, FindsSeededViolations) {
  const std::vector<Seeded> cases = {
      {"server/core/cut/cut.cc", "#include \"server/core/fem/model/model.h\"", true},
      {"server/core/fem/model/model.h", "#include \"server/core/cut/cut.h\"", true},
      {"server/core/mesh/triangle_mesh.h", "#include \"server/core/sheet/sheet.h\"", true},
      {"server/core/sheet/sheet.h", "#include \"server/service/host/clock.h\"", true},
      {"server/core/sheet/sheet.h", "#include \"server/core/fem/model/model.h\"", false},
      {"server/core/sheet/sheet.cc", "#include <boost/asio.hpp>", true},
      {"server/service/host/clock.cc", "  #  include <boost/asio/steady_timer.hpp>", false},
      {"server/service/host/clock.cc", "#include <boost/beast.hpp>", true},
      {"server/service/wire/scene_codec.h", "#include \"kerf/v1/scene.pb.h\"", false},
      {"server/service/wire/scene_codec.h", "#include \"kerf/v1/sheets.grpc.pb.h\"", true},
      {"server/service/stream/channel.h", "#include \"kerf/v1/stream.pb.h\"", true},
      {"server/service/svg/svg.cc", "#include <pugixml.hpp>", false},
      {"server/service/wire/curve_codec.cc", "#include <pugixml.hpp>", true},
      {"server/service/api/api.cc", "#include \"render/renderer.h\"", false},
      {"server/service/api/api.cc", "#include \"render/egl_context.h\"", true},
      {"server/service/api/api.cc", "#include <grpcpp/grpcpp.h>", true},
      {"server/service/rpc/server.cc", "#include \"server/service/ws/server.h\"", true},
      {"server/service/ws/server.cc", "#include \"server/service/rpc/server.h\"", true},
      {"server/service/ws/server.cc", "#include <boost/asio.hpp>", false},
      {"render/egl_renderer.cc", "#include \"server/base/result.h\"", true},
      {"client/cpp/mirror.h", "#include \"server/base/result.h\"", true},
      {"client/cli/run.cc", "#include \"server/core/sheet/sheet.h\"", true},
      {"client/cli/run.cc", "#include \"server/service/offline/run.h\"", false},
      {"client/cli/run.cc", "#include \"server/base/disk.h\"", false},
      {"client/cli/run.cc", "#include \"server/service/host/host.h\"", true},
      {"server/base/check.cc", "#include \"check.h\"", true},
      {"server/base/check.cc", "#include <cstdlib>", false},
      {"server/base/check.cc", "#include <Eigen/Core>", true},
      {"server/base/check.cc", "#include <server/base/check.h>", true},
      {"server/base/check.cc", "#include <nobody/knows.h>", true},
      {"server/teapot/brew.cc", "#include <vector>", true},
      {"server/cuttings/brew.cc", "#include <vector>", true},
      {"server/base/check.cc", "// #include \"server/core/mesh/ids.h\"", false},
  };
  for (const Seeded& seeded : cases) {
    const auto found = violations(seeded.file, "#include <vector>\n" + seeded.line + "\nint x;\n");
    EXPECT_EQ(!found.empty(), seeded.violates) << seeded.file << " with " << seeded.line;
  }
}

TEST(IncludeTable, NamesFileLineAndReason) {
  EXPECT_THAT(violations("server/core/cut/cut.cc", "#include <vector>\n#include \"server/core/fem/model/model.h\"\n"),
              testing::ElementsAre(
                  "server/core/cut/cut.cc:2: server/core/fem/model/model.h: server/core/cut may not include it"));
}

}  // namespace
