#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "server/base/result.h"

namespace kerf::ws {

// The bytes of a static file in one encoding.
struct AssetContent {
  std::string_view coding;                   // as in Content-Encoding: "br", "gzip"; empty for the file itself
  std::shared_ptr<const std::string> bytes;  // as sent
  std::string etag;                          // quoted, from the bytes
};

// One static file, ready to send.
struct Asset {
  AssetContent original;
  std::vector<AssetContent> encoded;  // from files beside it, the shorter coding first: "br", then "gzip"
  std::string media_type;             // e.g. "text/html; charset=utf-8"
  bool immutable = false;             // its name changes with its content: may be cached for ever

  // The content that a client with this Accept-Encoding header wants most, the shorter coding of two wanted alike. The
  // original where it wants none of the others, even where it refuses that.
  [[nodiscard]] const AssetContent& best_for(std::string_view accept_encoding) const;
};

// The files of a directory, read once. A request path is looked up, never turned into a file name: there is nothing a
// path could escape from, and what changes on disk later is not served.
class AssetTable {
 public:
  static constexpr std::size_t kMaxFiles = 4096;
  static constexpr std::size_t kMaxBytes = std::size_t{256} << 20;  // all files together

  AssetTable() = default;  // empty: every path is unknown

  // Reads the regular files below `directory`. Symbolic links and names that start with a dot are left out. NAME.br and
  // NAME.gz beside a file NAME are encodings of it, and have no path of their own; one that was written before NAME is
  // left out. Fails with
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
