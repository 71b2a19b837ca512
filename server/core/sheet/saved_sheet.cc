#include "server/core/sheet/saved_sheet.h"

#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "server/base/crc32c.h"
#include "server/core/sheet/scene_hash.h"
#include "server/core/sheet/sheet_fields.h"

template <>
struct kerf::Fields<kerf::sheet::SavedHeader> {
  static auto of(auto& of) {
    auto& [magic, format, num_sections, engine, scene, tick, state_hash, continuation_hash] = of;
    return std::tie(magic, format, num_sections, engine, scene, tick, state_hash, continuation_hash);
  }
};

namespace kerf::sheet {

namespace {

constexpr std::size_t kHeaderBytes = 8 + 4 + 4 + 5 * 8;
constexpr std::size_t kPrefixBytes = 4 + 8 + 4;

Error damaged(const std::string& where) {
  return data_loss("SAVED_SHEET_DAMAGED", "the saved sheet is damaged: " + where + "; use an earlier one");
}

// The members of a sheet, each written as one section: those of its clock and versions, its body, its cuts.
auto saved_sections(auto& impl) {
  auto [clock, moving, cuts, topology, settings, beginning, last] =
      Fields<std::remove_cvref_t<decltype(impl)>>::of(impl);
  return std::tuple_cat(std::make_tuple(std::tie(clock, topology, settings, beginning, last)),
                        Fields<MovingSheet>::of(moving), Fields<CutLog>::of(cuts));
}

// Reads the members of a sheet that is as its scene made it. Checkpoints have its settings, too.
class SheetReader : public FieldReader {
 public:
  SheetReader(std::string_view bytes, const MovingState& begun) : FieldReader(bytes), begun_(begun) {}
  template <class T>
  [[nodiscard]] T make() const {
    if constexpr (std::is_same_v<T, Checkpoint>) {
      return {begun_, {}, {}};
    } else {
      return {};
    }
  }

 private:
  const MovingState& begun_;
};

// Splits what follows the header into sections, and checks their sums.
Result<std::vector<std::string_view>> split(std::string_view rest, std::uint32_t num_sections) {
  std::vector<std::string_view> sections;
  for (std::uint32_t i = 0; i < num_sections; ++i) {
    const std::string name = "section " + std::to_string(i);
    std::uint32_t number = 0, sum = 0;
    std::uint64_t length = 0;
    FieldReader prefix(rest.substr(0, kPrefixBytes));
    visit(prefix, number);
    visit(prefix, length);
    visit(prefix, sum);
    if (!prefix.is_done() || length > rest.size() - kPrefixBytes) return damaged(name + " is not whole");
    const std::string_view bytes = rest.substr(kPrefixBytes, length);
    if (number != i || (crc32c(rest.substr(0, 12)) ^ crc32c(bytes)) != sum) return damaged(name + " has a wrong sum");
    sections.push_back(bytes);
    rest.remove_prefix(kPrefixBytes + bytes.size());
  }
  if (!rest.empty()) return damaged("bytes follow its last section");
  return sections;
}

// Returns true if arrays have the sizes that the mesh says, as those of every sheet have.
bool fits(const MovingSheet& moving, const CutLog& cuts) {
  const Eigen::Index count = moving.mesh().num_vertices();
  return moving.state().x.cols() == count && moving.state().v.cols() == count &&
         cuts.pieces().size() == static_cast<std::size_t>(moving.mesh().num_pieces());
}

}  // namespace

Result<SavedHeader> read_saved_header(std::string_view saved) {
  SavedHeader header;
  FieldReader reader(saved.substr(0, kHeaderBytes));
  visit(reader, header);
  if (!reader.is_done() || header.magic != SavedHeader::kMagic) {
    return invalid_argument("SAVED_SHEET_FORMAT", "these bytes are no saved sheet, or not all of one");
  }
  if (header.format != SavedHeader::kFormat) {
    return invalid_argument("SAVED_SHEET_FORMAT", "the saved sheet has format " + std::to_string(header.format) +
                                                      "; this version reads " + std::to_string(SavedHeader::kFormat));
  }
  std::uint32_t sum = 0;
  FieldReader last(saved.substr(kHeaderBytes, sizeof(sum)));
  visit(last, sum);
  if (!last.is_done() || sum != crc32c(saved.substr(0, kHeaderBytes))) return damaged("its header has a wrong sum");
  return header;
}

std::uint64_t Sheet::continuation_hash() const {
  FieldHasher hasher;
  visit(hasher, *impl_);
  return hasher.value();
}

void Sheet::save(const std::function<void(std::string_view)>& sink) const {
  const auto sections = saved_sections(*impl_);
  SavedHeader header;
  header.num_sections = std::tuple_size_v<decltype(sections)>;
  header.engine = engine_hash();
  if (!impl_->scene) impl_->scene = scene_hash(impl_->moving.initial());
  header.scene = *impl_->scene;
  header.tick = tick();
  header.state_hash = state_hash();
  header.continuation_hash = continuation_hash();
  FieldWriter first;
  visit(first, header);
  const std::uint32_t header_sum = crc32c(first.bytes());
  visit(first, header_sum);
  sink(first.bytes());
  std::uint32_t number = 0;
  FieldWriter content;
  const auto write = [&](const auto& section) {
    content.clear();
    visit(content, section);
    FieldWriter prefix;
    visit(prefix, number);
    prefix.count(content.bytes().size(), 1);
    const std::uint32_t sum = crc32c(prefix.bytes()) ^ crc32c(content.bytes());
    visit(prefix, sum);
    sink(prefix.bytes());
    sink(content.bytes());
    ++number;
  };
  std::apply([&](const auto&... section) { (write(section), ...); }, sections);
}

Result<Sheet> Sheet::load(scene::SheetConfig config, std::string_view saved) {
  return load(std::move(config), saved, fem::make_integrator);
}

Result<Sheet> Sheet::load(scene::SheetConfig config, std::string_view saved, IntegratorFactory make_integrator) {
  KERF_TRY_ASSIGN(const SavedHeader header, read_saved_header(saved));
  KERF_TRY_ASSIGN(const std::vector<std::string_view> bytes,
                  split(saved.substr(kHeaderBytes + sizeof(std::uint32_t)), header.num_sections));
  KERF_TRY_ASSIGN(Sheet sheet, create(std::move(config), std::move(make_integrator)));
  Impl& impl = *sheet.impl_;
  impl.scene = scene_hash(impl.moving.initial());
  if (impl.scene != header.scene) {
    return failed_precondition("SAVED_SHEET_OF_ANOTHER_SCENE",
                               "the saved sheet was made from another scene, or this build makes another sheet of it");
  }
  const MovingState begun = impl.moving.initial_state();
  auto sections = saved_sections(impl);
  if (bytes.size() != std::tuple_size_v<decltype(sections)>) return damaged("it has another number of sections");
  std::size_t number = 0;
  bool is_read = true;
  const auto read = [&](auto& section) {
    SheetReader reader(bytes[number++], begun);
    visit(reader, section);
    is_read = is_read && reader.is_done();
  };
  std::apply([&](auto&... section) { (read(section), ...); }, sections);
  if (!is_read || sheet.continuation_hash() != header.continuation_hash || !fits(impl.moving, impl.cuts)) {
    return damaged("its sections do not fit its header");
  }
  impl.moving.resume();
  if (sheet.state_hash() != header.state_hash) {
    return failed_precondition("SAVED_SHEET_OF_ANOTHER_BUILD",
                               "this build derives another state from the saved sheet; load it with the build that "
                               "saved it");
  }
  return sheet;
}

}  // namespace kerf::sheet
