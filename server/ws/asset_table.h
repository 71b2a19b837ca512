#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "server/base/result.h"

namespace kerf::ws {

// One static file, ready to send.
struct Asset {
  std::shared_ptr<const std::string> content;  // bytes
  std::string media_type;                      // e.g. "text/html; charset=utf-8"
  std::string etag;                            // quoted, from the content
  bool immutable = false;                      // its name changes with its content: may be cached for ever
};

// The files of a directory, read once. A request path is looked up, never turned into a file name: there is nothing a
// path could escape from, and what changes on disk later is not served.
class AssetTable {
 public:
  static constexpr std::size_t kMaxFiles = 4096;
  static constexpr std::size_t kMaxBytes = std::size_t{256} << 20;  // all files together

  AssetTable() = default;  // empty: every path is unknown

  // Reads the regular files below `directory`. Symbolic links and names that start with a dot are left out. Fails with
  // NOT_FOUND where there is no directory or no index.html in it, RESOURCE_EXHAUSTED beyond the limits above.
  static Result<AssetTable> read(const std::filesystem::path& directory);

  // `path` is the path part of a request target, compared byte for byte, e.g. "/assets/index-1a2b.js"; "/" is
  // "/index.html". nullptr if there is none.
  [[nodiscard]] const Asset* find(std::string_view path) const;
  [[nodiscard]] std::size_t num_files() const { return assets_.size(); }

 private:
  std::map<std::string, Asset, std::less<>> assets_;
};

// By the extension of `path`; "application/octet-stream" for an unknown one.
std::string_view media_type_of(std::string_view path);

}  // namespace kerf::ws
