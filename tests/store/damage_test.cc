// Changed bytes of a store: what is read is right, or an error.

#include "tests/store/fixture.h"
#include "tests/support/trials.h"

namespace kerf::test {
namespace {

struct All {
  std::vector<std::string> parts;
  bool is_damage_known = false;  // something said that it is damaged
};

// Reads everything that a store holds.
All read_all(store::SqliteStore& store) {
  All all;
  const auto sheets = store.sheets();
  const auto requests = store.requests(1000, 1'000'000);
  all.is_damage_known = !sheets.ok() || !requests.ok() || requests->num_damaged > 0;
  if (all.is_damage_known) return all;
  for (const store::KeptRequest& one : requests->requests) {
    all.parts.push_back(one.request.key + std::to_string(one.request.body_hash) + one.request.reply +
                        std::to_string(one.sheet) + " " + std::to_string(one.seq) + " " +
                        std::to_string(one.at_unix_us));
  }
  for (const store::StoredSheet& sheet : *sheets) {
    all.is_damage_known = all.is_damage_known || sheet.is_damaged || sheet.num_damaged_states > 0;
    all.parts.push_back(sheet.id + sheet.scene + sheet.reason + std::to_string(sheet.created_unix_us) +
                        (sheet.is_quarantined ? "q" : "l"));
    const auto entries = store.entries(sheet.sheet, std::max<std::int64_t>(sheet.first_seq, 1) - 1);
    all.is_damage_known = all.is_damage_known || !entries.ok();
    if (!entries.ok()) continue;
    for (const host::JournalEntry& one : *entries) {
      all.parts.push_back(std::to_string(one.seq) + " " + std::to_string(one.tick) + one.content +
                          std::to_string(one.state_hash));
    }
    for (const store::StateInfo& info : sheet.states) {
      const auto state = store.read_state(sheet.sheet, info.seq, info.name);
      all.is_damage_known = all.is_damage_known || !state.ok();
      if (state.ok()) all.parts.push_back(state->name + state->content + std::to_string(state->tick));
    }
  }
  return all;
}

void fill(store::SqliteStore& store) {
  for (const std::int64_t sheet : {store.new_sheet_number(), store.new_sheet_number()}) {
    store.create(new_sheet(sheet, {request("Create " + std::to_string(sheet))}), nullptr);
    for (std::int64_t seq = 1; seq <= 12; ++seq) {
      store.append(entry(sheet, seq, std::string(40, static_cast<char>('a' + seq)),
                         {request("Cut " + std::to_string(100 * sheet + seq))}),
                   nullptr);
    }
    store.save(state(sheet, 3, "state three"), nullptr);
    store.save(state(sheet, 5, "state five", "named"), nullptr);
  }
  store.mark({{1, 500}});
  EXPECT_TRUE(store.wait_until_durable().ok());
}

TEST(DamagedStore, EachChangedByteIsRightOrAnError) {
  StoreOnLossyDisk on;
  fill(*on.open());
  const All whole = read_all(*on.open());
  ASSERT_FALSE(whole.is_damage_known);
  ASSERT_EQ(whole.parts.size(), 2u + 2u * 12u + 2u * 13u + 2u * 2u);
  const auto contents = on.disk.contents();
  const std::size_t stride = static_cast<std::size_t>(num_trials({.few = 97, .usual = 17, .many = 1}));
  int num_refused = 0, num_known = 0, num_right = 0;
  for (const auto& [path, content] : contents) {
    for (std::size_t at = first_seed() % stride; at < content.size(); at += content.size() < 1000 ? 1 : stride) {
      auto changed = contents;
      changed[path][at] = static_cast<char>(changed[path][at] ^ (at % 2 == 0 ? 0xff : 1 << at % 8));
      on.disk.set_contents(changed);
      auto opened = store::SqliteStore::open(on.options());
      if (!opened.ok()) {
        ++num_refused;
        ASSERT_EQ(on.disk.contents()[path], changed[path]) << path << " " << at << ": a refused file was changed";
        continue;
      }
      const All found = read_all(**opened);
      ++(found.is_damage_known ? num_known : num_right);
      if (!found.is_damage_known) {
        ASSERT_EQ(found.parts, whole.parts) << path << " " << at;
      }
    }
  }
  EXPECT_GT(num_refused, 10);
  EXPECT_GT(num_known, 10);
  EXPECT_GT(num_right, 10) << "unused room of pages";
  EXPECT_TRUE(on.failures().empty());
}

// The log of a store that was killed: a changed byte looks as a loss of power in the middle of a commit does.
TEST(DamagedStore, AChangedLogHoldsAnEarlierState) {
  StoreOnLossyDisk on;
  std::map<std::string, std::string> contents;
  std::vector<All> steps;
  {
    const auto store = on.open();
    steps.push_back(read_all(*store));
    store->create(new_sheet(store->new_sheet_number()), nullptr);
    for (std::int64_t seq = 1; seq <= 4; ++seq) {
      EXPECT_TRUE(store->wait_until_durable().ok());
      steps.push_back(read_all(*store));
      store->append(entry(1, seq, "x", {request("Cut " + std::to_string(seq))}), nullptr);
    }
    EXPECT_TRUE(store->wait_until_durable().ok());
    steps.push_back(read_all(*store));
    contents = on.disk.contents();
  }
  const std::string log = "/store/kerf.db-wal";
  const std::size_t stride = static_cast<std::size_t>(num_trials({.few = 1009, .usual = 101, .many = 7}));
  for (std::size_t at = 0; at < contents[log].size(); at += stride) {
    auto changed = contents;
    changed[log][at] = static_cast<char>(changed[log][at] ^ 0x40);
    on.disk.set_contents(changed);
    const All found = read_all(*on.open());
    ASSERT_FALSE(found.is_damage_known);
    ASSERT_TRUE(std::any_of(steps.begin(), steps.end(), [&](const All& step) { return step.parts == found.parts; }))
        << at;
  }
}

}  // namespace
}  // namespace kerf::test
