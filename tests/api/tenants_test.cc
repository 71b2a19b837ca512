// Limits on what the callers of a tenant do.

#include "server/service/api/tenants.h"

#include <gmock/gmock.h>

#include "kerf/v1/access_service.pb.h"
#include "server/service/api/image_session.h"
#include "server/service/api/watch_session.h"
#include "tests/api/fixture.h"

namespace kerf::api {
namespace {

class TenantsApiTest : public ApiTest {
 protected:
  TenantsApiTest() : ApiTest(limited()) {
    read("tenant lab sheets=2 vertices=120 streams=2 image-streams=1 cuts-per-s=2");
    authenticator_ = std::make_unique<auth::Authenticator>([] { return std::int64_t{1000}; });
    authenticator_->set_tokens(
        auth::parse_token_file("tenant lab\n" + alice_.line + "\n" + operator_.line).value().tokens);
    tenants_ = &of_lab_;
    make_api({}, nullptr);
    be(alice_);
  }
  host::HostOptions limited() {
    host::HostOptions options = small_host();
    options.find_tenant = [this](const std::string& tenant) { return of_lab_.sheet_limits(tenant); };
    return options;
  }
  void read(const std::string& file) { of_lab_.set(auth::parse_token_file(file).value().tenants); }
  void be(const auth::NewToken& token) { caller_ = api_->caller_of("Bearer " + token.text, {}).value(); }
  std::string cut(const std::string& sheet = "lab-1") {
    const Status allowed = api_->allow(caller_, cut_request("sheets/" + sheet, 0.5));
    return allowed.ok() ? "" : allowed.error().reason;
  }
  std::shared_ptr<WatchSession> watch() {
    const std::shared_ptr<WatchSession> session = api_->watch(caller_);
    v1::WatchRequest start;
    start.mutable_start()->set_name("sheets/lab-1");
    session->on_request(start);
    host_->wait_idle();
    return session;
  }

  test::ManualClock of_tenants_;
  Tenants of_lab_{of_tenants_};
  const auth::NewToken alice_ = auth::make_token({"alice", auth::Scope::kAdmin, "", "", "lab"}).value();
  const auth::NewToken operator_ = auth::make_token({"operator", auth::Scope::kAdmin, "", "", ""}).value();
};

TEST_F(TenantsApiTest, CutsHaveARate) {
  ASSERT_TRUE(create_sheet("lab-1", true).ok());
  EXPECT_EQ(cut(), "");
  EXPECT_EQ(cut(), "");
  EXPECT_EQ(cut(), "");
  EXPECT_EQ(cut(), "");
  EXPECT_EQ(cut(), "TENANT_CUTS") << "twice the rate at once";
  EXPECT_TRUE(api_->allow(caller_, v1::GetAccessRequest()).ok()) << "nothing else is counted";
  be(operator_);
  EXPECT_EQ(cut(), "") << "of no tenant";
  be(alice_);
  of_tenants_.move_to(of_tenants_.now() + 500ms);
  EXPECT_EQ(cut(), "");
  EXPECT_EQ(cut(), "TENANT_CUTS");
  read("tenant lab sheets=2 streams=2 cuts-per-s=0");
  for (int i = 0; i < 100; ++i) EXPECT_EQ(cut(), "") << "no limit";
}

TEST_F(TenantsApiTest, ATenantWithoutVerticesLeftCutsNoMore) {
  ASSERT_TRUE(create_sheet("lab-1", true).ok());  // 49 vertices
  EXPECT_EQ(cut(), "");
  ASSERT_TRUE(create_sheet("lab-2", true).ok());
  EXPECT_EQ(cut(), "");
  read("tenant lab vertices=98 cuts-per-s=0");
  EXPECT_EQ(cut(), "TENANT_VERTICES");
  EXPECT_TRUE(api_->allow(caller_, v1::UndoCutRequest()).ok()) << "that gives some back";
}

TEST_F(TenantsApiTest, StreamsAreCountedWhileTheyAreOpen) {
  ASSERT_TRUE(create_sheet("lab-1", true).ok());
  auto first = watch();
  const auto second = watch();
  EXPECT_FALSE(second->failure());
  EXPECT_EQ(watch()->failure()->reason, "TENANT_STREAMS");
  EXPECT_EQ(of_lab_.use_of("lab")->streams, 2);
  first->close();
  EXPECT_EQ(of_lab_.use_of("lab")->streams, 1);
  EXPECT_FALSE(watch()->failure());
  be(operator_);
  EXPECT_FALSE(watch()->failure());
  EXPECT_EQ(of_lab_.open_stream("lab", Tenants::Stream::kPictures).ok(), true);
  const auto held = of_lab_.open_stream("lab", Tenants::Stream::kPictures);
  EXPECT_EQ(of_lab_.open_stream("lab", Tenants::Stream::kPictures).error().reason, "TENANT_IMAGE_STREAMS");
  EXPECT_TRUE(of_lab_.open_stream("shop", Tenants::Stream::kPictures).ok());
}

TEST_F(TenantsApiTest, AccessSaysWhatIsUsedOfEachLimit) {
  ASSERT_TRUE(create_sheet("lab-1", true).ok());
  const auto stream = watch();
  const v1::Access access = call(&Api::get_access, v1::GetAccessRequest()).value();
  EXPECT_EQ(access.tenant(), "lab");
  EXPECT_EQ(access.sheets(), "lab-*");
  std::map<std::string, std::pair<double, double>> quotas;
  for (const v1::Quota& quota : access.quotas()) quotas[quota.name()] = {quota.used(), quota.limit()};
  ASSERT_EQ(quotas.size(), 7u);
  EXPECT_EQ(quotas["sheets"], std::pair(1.0, 2.0));
  EXPECT_EQ(quotas["vertices"], std::pair(49.0, 120.0));
  EXPECT_EQ(quotas["streams"], std::pair(1.0, 2.0));
  EXPECT_EQ(quotas["image-streams"], std::pair(0.0, 1.0));
  EXPECT_EQ(quotas["workers"].second, 1.0);
  EXPECT_EQ(quotas["state-mib"].second, 128.0);
  EXPECT_EQ(quotas["cuts-per-s"].second, 2.0);
  be(operator_);
  EXPECT_EQ(call(&Api::get_access, v1::GetAccessRequest()).value().quotas_size(), 0);
}

}  // namespace
}  // namespace kerf::api
