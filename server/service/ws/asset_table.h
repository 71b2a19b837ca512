#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "server/base/result.h"

namespace kerf::ws {

// Holds a static file in one encoding.
struct AssetContent {
  std::string_view coding;                   // As in Content-Encoding: "br", "gzip"; empty for the file itself.
  std::shared_ptr<const std::string> bytes;  // As sent.
  std::string etag;                          // Quoted, computed from the bytes.
};

// Holds one static file, ready to send.
struct Asset {
  AssetContent original;
  std::vector<AssetContent> encoded;  // Made from files beside it, the shorter coding first: "br", then "gzip".
  std::string media_type;             // e.g. "text/html; charset=utf-8"
  bool immutable = false;             // Its name changes with its content: may be cached for ever.

  // Returns the content that a client with this Accept-Encoding header prefers, the shorter coding of two preferred
  // equally. Falls back to the original, even if the client refuses that.
  [[nodiscard]] const AssetContent& best_for(std::string_view accept_encoding) const;
};

// Holds the files of a directory, read once. A request path is looked up, never turned into a file name, so no path can
// escape the directory. Later changes on disk are not served.
class AssetTable {
 public:
  static constexpr std::size_t kMaxFiles = 4096;
  static constexpr std::size_t kMaxBytes = std::size_t{256} << 20;  // All files together.

  AssetTable() = default;  // Empty: every path is unknown.

  // Reads the regular files below `directory`, except symbolic links and names that start with a dot. NAME.br and
  // NAME.gz beside a file NAME are encodings of it and have no path of their own; those older than NAME are left out.
  // NOT_FOUND if there is no directory or no index.html in it; RESOURCE_EXHAUSTED beyond the limits above.
  static Result<AssetTable> read(const std::filesystem::path& directory);

  // Adds the files of `site` below `prefix`, such as "/docs"; files that are there already stay.
  void mount(std::string_view prefix, AssetTable site);

  // Finds a file. `path` is the path part of a request target, compared byte for byte, e.g. "/assets/index-1a2b.js";
  // "/" is "/index.html", and "/docs/" is "/docs/index.html". Returns nullptr if there is none.
  [[nodiscard]] const Asset* find(std::string_view path) const;
  [[nodiscard]] std::size_t num_files() const { return assets_.size(); }

 private:
  std::map<std::string, Asset, std::less<>> assets_;
};

// Returns the media type by the extension of `path`; "application/octet-stream" for an unknown one.
std::string_view media_type_of(std::string_view path);

}  // namespace kerf::ws
