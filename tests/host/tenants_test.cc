// Limits of tenants on sheets, vertices, load and saved states, and their turns.

#include "server/service/host/tenants.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/host/fixture.h"

namespace kerf::host {
namespace {

using testing::HasSubstr;

TEST(TenantOf, IsWhatComesBeforeTheFirstHyphen) {
  EXPECT_EQ(tenant_of("lab-a-b"), "lab");
  EXPECT_EQ(tenant_of("lab"), "");
  EXPECT_EQ(tenant_of("lab-"), "lab");
  EXPECT_EQ(tenant_of(""), "");
}

class TenantsTest : public HostTest {
 protected:
  TenantsTest() : HostTest(options()) {}

  HostOptions options() {
    HostOptions options;
    options.find_tenant = [this](const std::string& name) -> std::optional<TenantLimits> {
      if (name != "lab") return std::nullopt;
      return limits_;
    };
    return options;
  }

  std::string reason_of(const std::string& id, scene::SheetConfig config, bool paused = true) {
    Answers<SheetStatus> answers;
    host_->create_sheet(id, std::move(config), paused, answers.callback());
    host_->wait_idle();
    if (const Result<SheetStatus> made = answers.at(0); !made.ok()) message_ = made.error().message;
    return answers.reason(0);
  }

  TenantLimits limits_;
  std::string message_;
};

TEST_F(TenantsTest, LimitTheSheetsWhoseIdsBeginWithTheirName) {
  limits_.max_sheets = 2;
  EXPECT_EQ(reason_of("lab-1", small_sheet()), "done");
  EXPECT_EQ(reason_of("lab-2", small_sheet()), "done");
  EXPECT_EQ(reason_of("lab-3", small_sheet()), "TENANT_SHEETS");
  EXPECT_THAT(message_, HasSubstr("tenant \"lab\" may have 2 sheets"));
  EXPECT_THAT(message_, HasSubstr("sheets="));
  for (const char* const other : {"lab", "labs-1", "la-1", "shop-1"})
    EXPECT_EQ(reason_of(other, small_sheet()), "done");
  Answers<Nothing> deleted;
  host_->delete_sheet("lab-1", deleted.callback());
  host_->wait_idle();
  EXPECT_EQ(host_->tenant_use("lab").sheets, 1);
  EXPECT_EQ(reason_of("lab-3", small_sheet()), "done");
}

TEST_F(TenantsTest, ARefusedSheetTakesNothing) {
  limits_.max_sheets = 2;
  EXPECT_EQ(reason_of("lab-1", small_sheet()), "done");
  EXPECT_EQ(reason_of("lab-1", small_sheet()), "SHEET_EXISTS");
  scene::SheetConfig broken = small_sheet();
  broken.tick_rate_hz = -1.0;
  EXPECT_NE(reason_of("lab-2", broken), "done");
  const TenantUse use = host_->tenant_use("lab");
  EXPECT_EQ(use.sheets, 1);
  EXPECT_EQ(use.vertices, 25);
}

TEST_F(TenantsTest, LimitVerticesOfAllSheetsAlsoIfAMeshDeclaresNone) {
  limits_.max_vertices = 60;
  EXPECT_EQ(reason_of("lab-1", small_sheet()), "done");
  EXPECT_EQ(reason_of("lab-2", small_sheet()), "done");
  EXPECT_EQ(host_->tenant_use("lab").vertices, 50);
  EXPECT_EQ(reason_of("lab-3", small_sheet()), "TENANT_VERTICES");
  scene::SheetConfig text = small_sheet();
  text.pins.clear();
  text.mesh = scene::ObjSource{"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n"};
  EXPECT_EQ(reason_of("lab-3", text), "done");
  EXPECT_EQ(host_->tenant_use("lab").vertices, 54);
  EXPECT_EQ(reason_of("lab-4", text), "done");
  EXPECT_EQ(reason_of("lab-5", text), "TENANT_VERTICES") << "found only when it is built";
  EXPECT_EQ(host_->tenant_use("lab").vertices, 58);
}

TEST_F(TenantsTest, LimitTheWorkersThatRunningSheetsNeed) {
  limits_.max_workers = 0.5;
  scene::SheetConfig large =
      at_50_hz(scenes::hanging(101));  // guessed: 10,201 vertices * 300 ns * 50 Hz = 0.15 workers
  EXPECT_EQ(reason_of("lab-1", large, false), "done");
  EXPECT_GT(host_->tenant_use("lab").workers, 0.0);
  scene::SheetConfig huge = at_50_hz(scenes::hanging(201));  // 0.61 workers
  EXPECT_EQ(reason_of("lab-2", huge, false), "TENANT_LOAD");
  EXPECT_THAT(message_, HasSubstr("paused"));
  EXPECT_EQ(reason_of("lab-2", huge, true), "done") << "a paused sheet needs none";
  EXPECT_EQ(reason_of("shop-2", huge, false), "done");
}

TEST_F(TenantsTest, LimitTheNeedOfSheetsThatAreResumedOrMadeFaster) {
  for (const char* const id : {"lab-1", "lab-2", "lab-3"}) ASSERT_EQ(reason_of(id, small_sheet(), true), "done");
  const auto resume = [this](const std::string& id) {
    Answers<SheetStatus> answers;
    host_->resume(id, answers.callback());
    host_->wait_idle();
    return answers.reason(0);
  };
  const auto hasten = [this](const std::string& id, double speed) {
    Answers<SheetStatus> answers;
    host_->set_speed(id, speed, answers.callback());
    host_->wait_idle();
    return answers.reason(0);
  };
  ASSERT_EQ(resume("lab-1"), "done");
  const double each = host_->tenant_use("lab").workers;
  ASSERT_GT(each, 0.0);
  limits_.max_workers = 1.5 * each;
  EXPECT_EQ(resume("lab-1"), "done") << "it runs already";
  EXPECT_EQ(hasten("lab-1", 4.0), "TENANT_LOAD");
  EXPECT_EQ(resume("lab-2"), "TENANT_LOAD");
  EXPECT_EQ(hasten("lab-2", 0.25), "done") << "it is paused";
  EXPECT_EQ(resume("lab-2"), "done");
  EXPECT_EQ(resume("lab-3"), "TENANT_LOAD");
  EXPECT_NEAR(host_->tenant_use("lab").workers, 1.25 * each, 1e-5);
}

TEST_F(TenantsTest, NoSheetAloneGetsMoreVerticesByCuts) {
  limits_.max_vertices = 40;
  ASSERT_EQ(reason_of("lab-1", small_sheet()), "done");  // 25
  EXPECT_EQ(status("lab-1").config->max_vertices, 40);
}

TEST_F(TenantsTest, LimitSavedStates) {
  ASSERT_EQ(reason_of("lab-1", small_sheet()), "done");
  ASSERT_EQ(reason_of("lab-2", small_sheet()), "done");
  const auto save = [this](const std::string& sheet, const std::string& name, bool overwrite) {
    Answers<SavedStateStatus> answers;
    host_->save_state(sheet, name, overwrite, answers.callback());
    host_->wait_idle();
    return answers.reason(0);
  };
  EXPECT_EQ(save("lab-1", "a", false), "done");
  const std::int64_t each = host_->tenant_use("lab").state_bytes;
  EXPECT_GT(each, 0);
  limits_.max_state_bytes = 2 * each + each / 2;
  EXPECT_EQ(save("lab-2", "b", false), "done");
  EXPECT_EQ(save("lab-2", "c", false), "TENANT_STATES");
  EXPECT_EQ(save("lab-2", "b", true), "done") << "the one it replaces does not count";
  EXPECT_LE(host_->tenant_use("lab").state_bytes, limits_.max_state_bytes);
}

}  // namespace
}  // namespace kerf::host
