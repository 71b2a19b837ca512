#include "client/cpp/run_writer.h"

#include <minizip/zip.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <initializer_list>
#include <optional>
#include <span>
#include <sstream>
#include <system_error>
#include <utility>

namespace kerf::client {
namespace {

constexpr std::size_t kChunkBytes = std::size_t{8} << 20;  // Positions kept in memory before they are written.

static_assert(std::endian::native == std::endian::little, "arrays are written as they are in memory");

// Returns the header of an .npy file of version 1.0, a multiple of 64 bytes long. See NumPy's numpy.lib.format.
// `shape`: "3, 2", or "3," for one dimension.
std::string npy_header(const std::string& type, const std::string& shape) {
  constexpr std::size_t kPrefix = 10;
  std::string text = "{'descr': '" + type + "', 'fortran_order': False, 'shape': (" + shape + "), }";
  text.append(63 - (kPrefix + text.size()) % 64, ' ');
  text += '\n';
  const std::string length{static_cast<char>(text.size() & 0xff), static_cast<char>(text.size() >> 8)};
  return std::string("\x93NUMPY\x01\x00", 8) + length + text;
}

std::string shape_of(std::initializer_list<std::size_t> lengths) {
  std::string text;
  for (const std::size_t length : lengths) text += std::to_string(length) + ",";
  return text;
}

}  // namespace

// Writes the .npz file: a zip file of .npy files. After a failure nothing more is written.
class RunWriter::Archive {
 public:
  explicit Archive(const std::string& path)
      : path_(path), part_(path + ".part"), zip_(zipOpen64(part_.c_str(), APPEND_STATUS_CREATE)) {
    if (zip_ == nullptr) fail();
  }
  ~Archive() {
    if (zip_ == nullptr) return;
    zipClose(zip_, nullptr);
    std::remove(part_.c_str());
  }
  Archive(const Archive&) = delete;
  Archive& operator=(const Archive&) = delete;

  template <typename Number>
  void write(const std::string& name, const std::string& type, const std::string& shape,
             std::span<const Number> numbers) {
    if (!is_open()) return;
    errno = 0;
    zip_fileinfo about{};
    about.tmz_date.tm_year = 1980;  // Equal runs give equal bytes.
    about.tmz_date.tm_mday = 1;
    const std::string header = npy_header(type, shape);
    constexpr int kStored = 0;  // Positions hardly compress.
    if (zipOpenNewFileInZip64(zip_, (name + ".npy").c_str(), &about, nullptr, 0, nullptr, 0, nullptr, kStored, 0, 1) !=
            ZIP_OK ||
        !put(header.data(), header.size()) || !put(numbers.data(), numbers.size_bytes()) ||
        zipCloseFileInZip(zip_) != ZIP_OK) {
      fail();
    }
  }

  void close() {
    if (!is_open()) return;
    errno = 0;
    const int closed = zipClose(std::exchange(zip_, nullptr), nullptr);
    std::error_code wrong;
    if (closed == ZIP_OK) std::filesystem::rename(part_, path_, wrong);
    if (closed == ZIP_OK && !wrong) return;
    if (wrong) errno = wrong.value();
    fail();
    std::remove(part_.c_str());
  }

  [[nodiscard]] bool is_open() const { return zip_ != nullptr && !failure_; }
  [[nodiscard]] const std::optional<Failure>& failure() const { return failure_; }

 private:
  bool put(const void* bytes, std::size_t size) {
    return size == 0 || zipWriteInFileInZip(zip_, bytes, static_cast<unsigned>(size)) == ZIP_OK;
  }
  void fail() {
    const std::string why = std::generic_category().message(errno == 0 ? EIO : errno);
    failure_ = Failure{grpc::StatusCode::UNKNOWN, "FILE_NOT_WRITTEN", "cannot write " + path_ + ": " + why, ""};
  }

  std::string path_;
  std::string part_;
  zipFile zip_;  // Null once closed.
  std::optional<Failure> failure_;
};

RunWriter::RunWriter(std::unique_ptr<Archive> archive) : archive_(std::move(archive)) {}
RunWriter::~RunWriter() = default;

Result<std::unique_ptr<RunWriter>> RunWriter::open(const std::string& path) {
  std::error_code broken;
  std::filesystem::path meant = path;
  if (std::filesystem::is_symlink(path)) meant = std::filesystem::canonical(path, broken);  // Keeps a link a link.
  if (broken || (std::filesystem::exists(meant) && !std::filesystem::is_regular_file(meant))) {
    return Failure{grpc::StatusCode::UNKNOWN, "FILE_NOT_WRITTEN", path + " is not a regular file, as a run must be",
                   ""};
  }
  auto archive = std::make_unique<Archive>(meant.string());
  if (archive->failure()) return *archive->failure();
  return std::unique_ptr<RunWriter>(new RunWriter(std::move(archive)));
}

Result<Done> RunWriter::state() const {
  if (archive_->failure()) return *archive_->failure();
  return Done{};
}

Result<Done> RunWriter::add(const Mirror& mirror) {
  if (!ticks_.empty() && mirror.tick() < ticks_.back()) {
    return Failure{grpc::StatusCode::FAILED_PRECONDITION, "FRAME_ORDER",
                   "the frame of tick " + std::to_string(mirror.tick()) + " follows that of tick " +
                       std::to_string(ticks_.back()) + ": start another file",
                   ""};
  }
  if (topology_versions_.empty() || topology_versions_.back() != mirror.topology_version() ||
      epoch_ != mirror.epoch()) {
    epoch_ = mirror.epoch();
    flush();
    add_topology(mirror);
  } else if (positions_.size() * sizeof(float) > kChunkBytes) {
    flush();
  }
  ticks_.push_back(mirror.tick());
  ++num_waiting_;
  for (std::int32_t vertex = 0; vertex < mirror.num_vertices(); ++vertex) {
    for (const double coordinate : mirror.position(vertex)) positions_.push_back(static_cast<float>(coordinate));
    if (mirror.has_strains()) strains_.push_back(static_cast<float>(mirror.strain(vertex)));
  }
  return state();
}

Result<Done> RunWriter::close() {
  if (!archive_->is_open()) return state();
  flush();
  std::ostringstream meta;
  meta << R"({"format": "kerf-run", "version": 1, "chunks": [)";
  const char* comma = "";
  for (const Chunk& chunk : chunks_) {
    meta << comma << R"({"topology": )" << chunk.topology << R"(, "chunk": )" << chunk.number << R"(, "frames": )"
         << chunk.frames << "}";
    comma = ", ";
  }
  meta << R"(], "topology_versions": [)";
  comma = "";
  for (const std::int32_t version : topology_versions_) {
    meta << comma << version;
    comma = ", ";
  }
  meta << "]}";
  const std::string text = meta.str();
  archive_->write<char>("meta", "|u1", shape_of({text.size()}), text);
  archive_->write<std::int64_t>("ticks", "<i8", shape_of({ticks_.size()}), ticks_);
  archive_->close();
  return state();
}

void RunWriter::add_topology(const Mirror& mirror) {
  const std::string number = std::to_string(topology_versions_.size());
  topology_versions_.push_back(mirror.topology_version());
  num_vertices_ = static_cast<std::size_t>(mirror.num_vertices());
  std::vector<std::int32_t> triangles, pieces;  // Only those of slots with material.
  for (std::size_t slot = 0; slot < mirror.triangles().size(); ++slot) {
    const auto& triangle = mirror.triangles()[slot];
    if (triangle[0] < 0) continue;
    triangles.insert(triangles.end(), triangle.begin(), triangle.end());
    pieces.push_back(mirror.pieces()[slot]);
  }
  archive_->write<std::int32_t>("triangles_" + number, "<i4", shape_of({pieces.size(), 3}), triangles);
  archive_->write<std::int32_t>("pieces_" + number, "<i4", shape_of({pieces.size()}), pieces);
  archive_->write<float>("material_positions_" + number, "<f4", shape_of({num_vertices_, 2}),
                         mirror.material_positions());
}

void RunWriter::flush() {
  if (num_waiting_ == 0) return;
  const std::size_t topology = topology_versions_.size() - 1;
  const auto number = static_cast<std::size_t>(
      std::count_if(chunks_.begin(), chunks_.end(), [&](const Chunk& each) { return each.topology == topology; }));
  chunks_.push_back({topology, number, num_waiting_});
  const std::string name = std::to_string(topology) + "_" + std::to_string(number);
  archive_->write<float>("positions_" + name, "<f4", shape_of({num_waiting_, num_vertices_, 3}), positions_);
  if (strains_.size() == num_waiting_ * num_vertices_) {
    archive_->write<float>("strains_" + name, "<f4", shape_of({num_waiting_, num_vertices_}), strains_);
  }
  num_waiting_ = 0;
  positions_.clear();
  strains_.clear();
}

}  // namespace kerf::client
