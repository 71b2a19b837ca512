#include "server/service/offline/inspect.h"

#include <algorithm>
#include <utility>

#include "server/base/text_encoding.h"
#include "server/core/scene/sheet_config.h"
#include "server/service/drawing/inflate.h"
#include "server/service/wire/mesh_report_codec.h"

namespace kerf::offline {
namespace {

constexpr std::size_t kFirstBytes = 4096;

bool ends_with(const std::string& path, std::string_view ending) {
  return path.size() >= ending.size() &&
         std::equal(ending.begin(), ending.end(), path.end() - static_cast<std::ptrdiff_t>(ending.size()),
                    [](char wanted, char c) { return wanted == (c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c); });
}

}  // namespace

FileKind kind_of_file(Disk& disk, const std::string& path) {
  const Result<std::string> content = disk.read_file(path, scene::kMaxMeshFileBytes);
  const bool is_packed = content.ok() && drawing::is_gzip(*content);
  const auto is_named = [&](const std::string& ending) {
    return ends_with(path, ending) || (is_packed && ends_with(path, ending + ".gz"));
  };
  if (!content.ok()) return is_named(".ply") ? FileKind::kPly : FileKind::kObj;
  const std::string start =
      utf8_text(is_packed ? drawing::inflated_start(*content, kFirstBytes) : content->substr(0, kFirstBytes));
  if (start.starts_with("ply\n") || start.starts_with("ply\r") || start.starts_with("ply ")) {
    return FileKind::kPly;
  }
  const std::size_t first = std::min(start.find_first_not_of(" \t\r\n"), start.size());
  const std::string_view text = std::string_view(start).substr(first);
  if (text.starts_with('<')) return FileKind::kSvg;
  if (text.starts_with("AutoCAD Binary DXF")) return FileKind::kDxf;
  if (text.starts_with("0") && text.find("SECTION") != std::string_view::npos) return FileKind::kDxf;
  if (is_named(".ply")) return FileKind::kPly;
  if (is_named(".dxf")) return FileKind::kDxf;
  return is_named(".svg") || is_named(".svgz") ? FileKind::kSvg : FileKind::kObj;
}

Result<v1::MeshReport> inspect_mesh(v1::InspectMeshRequest request) {
  return wire::inspect_mesh(std::move(request));
}

}  // namespace kerf::offline
