// Who may include whom: reads every #include line of server/, render/ and client/ and compares it with the table below,
// which is the one in server/README.md. A folder that is not in the table fails, so a new one has to be thought about.
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

namespace {

namespace fs = std::filesystem;

struct Row {
  std::string folder;                    // files below it follow this row; the longest matching row counts
  std::vector<std::string> ours;         // folders, or single files, that may be included beside the own one
  std::vector<std::string> third_party;  // names of groups of kGroups
};

// Headers from outside, by prefix. "proto" are the generated messages, "grpc_stubs" the generated services.
struct Group {
  std::string name;
  std::vector<std::string> prefixes;
};

const std::vector<Group>& groups() {
  static const std::vector<Group> all = {
      {"front_doors", {"kerf/kerf.h", "kerf/client.h"}},
      {"clipper", {"polyclipping/"}},
      {"eigen", {"Eigen/"}},
      {"highway", {"hwy/"}},
      {"spectra", {"Spectra/"}},
      {"asio", {"boost/asio", "boost/system"}},
      {"boost", {"boost/"}},
      {"protobuf", {"google/protobuf/"}},
      {"grpc", {"grpc/", "grpc++/", "grpcpp/"}},
      {"prometheus", {"prometheus/"}},
      {"cli", {"CLI/"}},
      {"json", {"nlohmann/"}},
      {"xml", {"pugixml.hpp"}},
      {"zip", {"minizip/"}},
      {"gl", {"EGL/", "GL/", "GLES", "KHR/"}},
      {"images", {"png.h", "turbojpeg.h", "jpeglib.h", "vpx/", "libyuv/"}},
      {"posix",
       {"arpa/", "dirent.h", "fcntl.h", "malloc.h", "netdb.h", "netinet/", "poll.h", "pthread.h", "signal.h", "sys/",
        "termios.h", "time.h", "unistd.h"}},
  };
  return all;
}

const std::vector<Row>& table() {
  static const std::vector<Row> rows = {
      {"server/base", {}, {"posix"}},
      // The library.
      {"server/core/linear", {"server/base"}, {"eigen", "highway"}},
      {"server/core/mesh", {"server/base"}, {"eigen"}},
      {"server/core/mesh/refine", {"server/core/mesh", "server/base"}, {"eigen"}},
      {"server/core/mesh/build", {"server/core/mesh/refine", "server/core/mesh", "server/base"}, {"eigen"}},
      {"server/core/cut",
       {"server/core/mesh/refine", "server/core/mesh", "server/core/linear", "server/base"},
       {"clipper", "eigen"}},
      {"server/core/contact", {"server/core/mesh", "server/core/linear", "server/base"}, {"eigen", "highway"}},
      {"server/core/fem/element", {"server/core/mesh", "server/core/linear", "server/base"}, {"eigen", "highway"}},
      {"server/core/fem/model",
       {"server/core/fem/element", "server/core/mesh", "server/core/linear", "server/base"},
       {"eigen", "highway"}},
      {"server/core/fem/leapfrog",
       {"server/core/fem/model", "server/core/fem/element", "server/core/mesh", "server/core/linear", "server/base"},
       {"eigen", "highway"}},
      {"server/core/fem/step",
       {"server/core/fem/leapfrog", "server/core/fem/model", "server/core/fem/element", "server/core/mesh",
        "server/core/linear", "server/base"},
       {"eigen"}},
      {"server/core/fem/statics",
       {"server/core/fem/model", "server/core/fem/element", "server/core/mesh", "server/core/linear", "server/base"},
       {"eigen", "spectra"}},
      {"server/core/scene",
       {"server/core/cut", "server/core/contact", "server/core/fem/statics", "server/core/fem/step",
        "server/core/fem/model", "server/core/fem/element", "server/core/mesh/build", "server/core/mesh/refine",
        "server/core/mesh", "server/core/linear", "server/base"},
       {"eigen"}},
      {"server/core/sheet",
       {"server/core/scene", "server/core/cut", "server/core/contact", "server/core/fem/statics",
        "server/core/fem/step", "server/core/fem/model", "server/core/fem/element", "server/core/mesh",
        "server/core/linear", "server/base"},
       {"eigen"}},
      {"server/core/analysis",
       {"server/core/sheet", "server/core/scene", "server/core/fem/statics", "server/core/fem/model",
        "server/core/fem/element", "server/core/mesh", "server/core/linear", "server/base"},
       {"eigen"}},
      {"server/core/kerf",
       {"server/core/analysis", "server/core/sheet", "server/core/scene", "server/core/contact", "server/core/cut",
        "server/core/fem/element", "server/base"},
       {}},
      // The service around it.
      {"server/service/codec", {"server/base"}, {}},
      {"server/service/svg", {"server/core/cut", "server/base"}, {"eigen", "xml"}},
      // The single files define what a sheet's functions return.
      {"server/service/host",
       {"server/core/sheet", "server/core/scene", "server/core/fem/step/integrator.h",
        "server/core/fem/step/softening.h", "server/core/fem/model/tick_cost.h", "server/core/mesh/triangle_mesh.h",
        "server/base"},
       {"asio", "eigen", "posix"}},
      {"server/service/wire",
       {"server/service/svg", "server/service/codec", "server/core/analysis", "server/core/sheet", "server/core/scene",
        "server/base"},
       {"eigen", "proto", "protobuf"}},
      {"server/service/offline",
       {"server/service/wire", "server/service/svg", "server/core/analysis", "server/core/sheet", "server/core/scene",
        "server/core/fem/model/tick_cost.h", "server/core/mesh/triangle_mesh.h", "server/base"},
       {"proto"}},
      {"server/service/stream", {"server/service/wire", "server/core/sheet", "server/base"}, {}},
      {"server/service/picture",
       {"server/service/stream", "server/service/host", "server/core/sheet", "server/core/mesh/triangle_mesh.h",
        "server/base", "render/renderer.h", "render/image.h", "render/video.h", "render/colours.h"},
       {"eigen", "proto"}},
      {"server/service/api",
       {"server/service/picture", "server/service/stream", "server/service/wire", "server/service/host",
        "server/core/analysis", "server/core/sheet", "server/core/scene", "server/core/fem/element/state.h",
        "server/core/mesh/triangle_mesh.h", "server/base", "render/renderer.h", "render/image.h", "render/video.h",
        "render/colours.h"},
       {"eigen", "proto"}},
      {"server/service/rpc",
       {"server/service/api", "server/service/stream", "server/service/wire", "server/service/host", "server/base",
        "render/renderer.h", "render/image.h", "render/video.h"},
       {"asio", "proto", "grpc_stubs", "grpc", "posix"}},
      {"server/service/ws",
       {"server/service/api", "server/service/wire", "server/service/host", "server/base", "render/renderer.h",
        "render/image.h", "render/video.h"},
       {"proto", "boost", "prometheus", "posix"}},
      {"server/app",
       {"server/service/rpc", "server/service/ws", "server/service/api", "server/service/wire", "server/service/host",
        "server/core/sheet", "server/core/scene", "server/base", "render/renderer.h", "render/image.h",
        "render/video.h"},
       {"proto", "cli", "posix"}},
      {"render", {}, {"gl", "images"}},
      {"client/cpp", {"server/service/codec"}, {"proto", "protobuf", "grpc_stubs", "grpc", "zip"}},
      // One embeds the core, the other asks a server.
      {"client/cpp/kerf", {"client/cpp"}, {}},
      {"client/examples", {}, {"front_doors", "posix"}},
      {"client/load", {"client/cpp", "server/base"}, {"proto", "grpc_stubs", "grpc", "boost", "json", "posix"}},
      // `kerf run` and `kerf replay` need no server: `offline` steps the sheet for them.
      {"client/cli",
       {"client/cpp", "client/load", "server/service/offline", "server/service/wire/json.h",
        "server/service/wire/error_codec.h", "server/base"},
       {"proto", "protobuf", "grpc_stubs", "grpc", "cli", "json", "posix"}},
      // Manual pages from the tables of both command lines.
      {"client/manual", {"client/cli", "server/app"}, {"cli"}},
  };
  return rows;
}

bool starts_with(std::string_view text, std::string_view prefix) {
  return text.substr(0, prefix.size()) == prefix;
}
bool ends_with(std::string_view text, std::string_view suffix) {
  return text.size() >= suffix.size() && text.substr(text.size() - suffix.size()) == suffix;
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

// The group of a header from outside; "std" for the standard library, nothing if unknown.
std::optional<std::string> group_of(std::string_view path) {
  if (ends_with(path, ".grpc.pb.h")) return "grpc_stubs";
  if (ends_with(path, ".pb.h")) return "proto";
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
      *group == "std" || contains(row.third_party, *group) || (*group == "asio" && contains(row.third_party, "boost"));
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
  const fs::path root = KERF_SOURCE_DIR;
  std::vector<std::string> found;
  int num_files = 0;
  for (const char* top : {"server", "render", "client"}) {
    for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
      if (!entry.is_regular_file() || !is_source(entry.path())) continue;
      std::ifstream in(entry.path(), std::ios::binary);
      const std::string source{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
      const auto here = violations(fs::relative(entry.path(), root).generic_string(), source);
      found.insert(found.end(), here.begin(), here.end());
      ++num_files;
    }
  }
  EXPECT_THAT(found, testing::IsEmpty());
  EXPECT_GT(num_files, 10) << "the search found next to nothing under " << root;
}

TEST(IncludeTable, ListsOnlyWhatExists) {
  const fs::path root = KERF_SOURCE_DIR;
  for (const Row& row : table()) {
    EXPECT_TRUE(fs::is_directory(root / row.folder)) << row.folder;
    for (const std::string& one : row.ours) EXPECT_TRUE(fs::exists(root / one)) << one << ", listed for " << row.folder;
    for (const std::string& name : row.third_party) {
      const bool known = name == "proto" || name == "grpc_stubs" ||
                         std::any_of(groups().begin(), groups().end(), [&](const Group& g) { return g.name == name; });
      EXPECT_TRUE(known) << name << ", listed for " << row.folder;
    }
  }
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
