#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "client/cpp/mirror.h"
#include "client/cpp/result.h"

namespace kerf::client {

// Writes the frames of a Watcher to an .npz file as they come, with at most some 8 MiB of them in memory. NumPy reads
// it, and so does kerf.load_run() of the Python package, whose RunWriter documents the content. The file exists,
// complete, when close() returns; until then the data is in FILE.part.
class RunWriter {
 public:
  // Opens a file. UNKNOWN FILE_NOT_WRITTEN if it cannot be written.
  static Result<std::unique_ptr<RunWriter>> open(const std::string& path);
  // Removes the unfinished file if close() was not called; an earlier file stays.
  ~RunWriter();
  RunWriter(const RunWriter&) = delete;
  RunWriter& operator=(const RunWriter&) = delete;

  // Adds the mirror's present state; not after close(). FAILED_PRECONDITION FRAME_ORDER if its tick is before the tick
  // added last, as after a restart of the server; FILE_NOT_WRITTEN if, for example, the disk is full.
  Result<Done> add(const Mirror& mirror);
  // Completes the file and gives it its name. Idempotent. FILE_NOT_WRITTEN if that fails.
  Result<Done> close();

  [[nodiscard]] std::int64_t num_frames() const { return static_cast<std::int64_t>(ticks_.size()); }

 private:
  struct Chunk {
    std::size_t topology;  // Index into topology_versions_.
    std::size_t number;    // Number among the topology's chunks.
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
  std::string epoch_;  // Epoch of the last topology.
  // These describe the chunk not yet written:
  std::size_t num_vertices_ = 0;
  std::size_t num_waiting_ = 0;   // Frames in the chunk.
  std::vector<float> positions_;  // num_waiting_ x num_vertices_ x 3, m
  std::vector<float> strains_;    // num_waiting_ x num_vertices_, or fewer if a frame had none.
};

}  // namespace kerf::client
