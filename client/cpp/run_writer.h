#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "client/cpp/mirror.h"
#include "client/cpp/result.h"

namespace kerf::client {

// Writes the frames of a Watcher to an .npz file as they come: at most some 8 MiB of them are in memory. NumPy reads
// it, and kerf.load_run() of the Python package, whose RunWriter says what is in it. The file is there, whole, when
// close() returns; until then what is written stands in FILE.part.
class RunWriter {
 public:
  // UNKNOWN FILE_NOT_WRITTEN where there can be no such file.
  static Result<std::unique_ptr<RunWriter>> open(const std::string& path);
  // Leaves no file behind where there was no close(); one of before stays.
  ~RunWriter();
  RunWriter(const RunWriter&) = delete;
  RunWriter& operator=(const RunWriter&) = delete;

  // Adds what the mirror shows. FAILED_PRECONDITION FRAME_ORDER where its tick is before the last one's: the server was
  // started anew. FILE_NOT_WRITTEN where the disk is full, say. Not after close().
  Result<Done> add(const Mirror& mirror);
  // Ends the file and gives it its name. Idempotent. FILE_NOT_WRITTEN.
  Result<Done> close();

  [[nodiscard]] std::int64_t num_frames() const { return static_cast<std::int64_t>(ticks_.size()); }

 private:
  struct Chunk {
    std::size_t topology;  // into topology_versions_
    std::size_t number;    // of the topology's chunks
    std::size_t frames;
  };
  class Archive;

  explicit RunWriter(std::unique_ptr<Archive> archive);
  void add_topology(const Mirror& mirror);
  void flush();
  [[nodiscard]] Result<Done> state() const;

  std::unique_ptr<Archive> archive_;
  std::vector<std::int64_t> ticks_;
  std::vector<Chunk> chunks_;
  std::vector<std::int32_t> topology_versions_;
  // Of the chunk that is not written yet:
  std::size_t num_vertices_ = 0;
  std::size_t num_waiting_ = 0;   // frames
  std::vector<float> positions_;  // num_waiting_ x num_vertices_ x 3, m
  std::vector<float> strains_;    // num_waiting_ x num_vertices_, or fewer where a frame had none
};

}  // namespace kerf::client
