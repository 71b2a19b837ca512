// Who may send which request, and the methods of AccessService.

#include "server/service/api/access.h"

#include <set>

#include <gmock/gmock.h>

#include "kerf/v1/access_service.pb.h"
#include "kerf/v1/files.pb.h"
#include "kerf/v1/store_service.pb.h"
#include "kerf/v1/stream.pb.h"
#include "server/service/api/image_session.h"
#include "server/service/api/watch_session.h"
#include "tests/api/fixture.h"
#include "tests/api/viewer.h"

namespace kerf::api {
namespace {

using auth::Scope;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

auth::Caller caller_with(Scope scope, const std::string& sheets = "*") {
  return {std::make_shared<const auth::Grant>("alice", auth::Rights{scope, sheets, 0}, [] { return std::int64_t{5}; }),
          {}};
}

template <typename Request>
Request named(const std::string& name) {
  Request request;
  request.set_name(name);
  return request;
}

std::string refusal(const Status& status) {
  return status.ok() ? "" : status.error().reason;
}

// A new RPC needs a rule; without one it is refused for everybody with tokens.
TEST(Access, EachRequestHasARule) {
  std::set<std::string> expected;
  for (const google::protobuf::FileDescriptor* file :
       {v1::GetSheetRequest::descriptor()->file(), v1::CreateCutRequest::descriptor()->file(),
        v1::InspectMeshRequest::descriptor()->file(), v1::GrabPointRequest::descriptor()->file(),
        v1::WatchRequest::descriptor()->file(), v1::RenderImageRequest::descriptor()->file(),
        v1::GetServerInfoRequest::descriptor()->file(), v1::GetStoreInfoRequest::descriptor()->file(),
        v1::GetAccessRequest::descriptor()->file()}) {
    ASSERT_EQ(file->service_count(), 1);
    for (int i = 0; i < file->service(0)->method_count(); ++i) {
      expected.insert(file->service(0)->method(i)->input_type()->full_name());
    }
  }
  ASSERT_EQ(expected.size(), 48U);
  // Uploads are checked by what announces them. A stream of pictures without requests begins with its start.
  for (const char* const parts : {"kerf.v1.UploadSheetRequest", "kerf.v1.ReplayRecordingRequest"}) {
    EXPECT_EQ(expected.erase(parts), 1U);
  }
  expected.insert({"kerf.v1.SheetUpload", "kerf.v1.RecordingUpload", "kerf.v1.WatchImagesStart"});
  const std::vector<std::string> found = messages_with_rules();
  EXPECT_EQ(std::set<std::string>(found.begin(), found.end()), expected);
  EXPECT_EQ(refusal(check_access(auth::everybody(), v1::Sheet())), "SCOPE_TOO_LOW") << "no rule, no access";
}

TEST(Access, EverySheetOfAListMustBeReached) {
  v1::StepSheetsRequest request;
  for (const char* const name : {"sheets/lab-1", "sheets/lab-2", "sheets/other"}) request.add_names(name);
  const Status refused = check_access(caller_with(Scope::kCut, "lab-*"), request);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().reason, "SHEET_NOT_FOUND");
  EXPECT_EQ(refused.error().field, "names[2]");
  EXPECT_EQ(sheets_of(request), (std::set<std::string>{"lab-1", "lab-2", "other"}));
  request.mutable_names()->RemoveLast();
  EXPECT_TRUE(check_access(caller_with(Scope::kCut, "lab-*"), request).ok());
  EXPECT_EQ(refusal(check_access(caller_with(Scope::kView, "lab-*"), request)), "SCOPE_TOO_LOW");
}

TEST(Access, AScopeIncludesThoseBeforeIt) {
  const auto refusals = [](const google::protobuf::Message& request) {
    std::vector<bool> allowed;
    for (const Scope scope : {Scope::kView, Scope::kCut, Scope::kAdmin}) {
      allowed.push_back(check_access(caller_with(scope), request).ok());
    }
    return allowed;
  };
  EXPECT_THAT(refusals(named<v1::GetSheetRequest>("sheets/a")), ElementsAre(true, true, true));
  EXPECT_THAT(refusals(named<v1::PauseSheetRequest>("sheets/a")), ElementsAre(false, true, true));
  EXPECT_THAT(refusals(named<v1::DeleteSheetRequest>("sheets/a")), ElementsAre(false, false, true));
  const Status refused = check_access(caller_with(Scope::kView), named<v1::DeleteSheetRequest>("sheets/a"));
  EXPECT_EQ(refused.error().code, ErrorCode::kPermissionDenied);
  EXPECT_THAT(refused.error().message, HasSubstr("scope admin; yours has view"));
}

TEST(Access, ASheetOutOfReachIsNotThere) {
  const auto caller = caller_with(Scope::kAdmin, "lab-*");
  EXPECT_TRUE(check_access(caller, named<v1::GetSheetRequest>("sheets/lab-1")).ok());
  EXPECT_TRUE(check_access(caller, named<v1::DeleteStateRequest>("sheets/lab-1/states/before")).ok());
  for (const char* const name : {"sheets/demo", "sheets/demo/states/lab-1", "sheets/lab"}) {
    const Status refused = check_access(caller, named<v1::DeleteStateRequest>(name));
    ASSERT_FALSE(refused.ok()) << name;
    EXPECT_EQ(refused.error().code, ErrorCode::kNotFound);
    EXPECT_EQ(refused.error().reason, "SHEET_NOT_FOUND");
    EXPECT_EQ(refused.error().field, "name");
  }
  v1::CreateCutRequest cut;
  cut.set_parent("sheets/demo");
  EXPECT_EQ(check_access(caller, cut).error().field, "parent");
  EXPECT_TRUE(check_access(caller, named<v1::GetSheetRequest>("nonsense")).ok()) << "the method says what is wrong";
  v1::WatchRequest watch;
  watch.mutable_start()->set_name("sheets/demo");
  EXPECT_EQ(check_access(caller, watch).error().field, "start.name");
  v1::WatchImagesRequest images;
  images.mutable_start()->set_name("sheets/demo");
  EXPECT_EQ(refusal(check_access(caller, images)), "SHEET_NOT_FOUND");
  images.mutable_pace();
  EXPECT_TRUE(check_access(caller, images).ok());
}

TEST(Access, NewSheetsHaveIdsWithinReach) {
  const auto all = caller_with(Scope::kAdmin), lab = caller_with(Scope::kAdmin, "lab-*");
  v1::CreateSheetRequest create;
  v1::SheetUpload upload;
  v1::RecordingUpload recording;
  const auto refusals = [&](const auth::Caller& caller) {
    return std::vector<std::string>{refusal(check_access(caller, create)), refusal(check_access(caller, upload)),
                                    refusal(check_access(caller, recording))};
  };
  EXPECT_THAT(refusals(all), ElementsAre("", "", "")) << "the server chooses an id";
  EXPECT_THAT(refusals(lab), ElementsAre("SHEET_NOT_ALLOWED", "SHEET_NOT_ALLOWED", "SHEET_NOT_ALLOWED"));
  create.mutable_scene()->set_sheet_id("lab-1");
  upload.mutable_sheet()->set_sheet_id("lab-2");
  recording.set_sheet_id("lab-3");
  EXPECT_THAT(refusals(lab), ElementsAre("", "", ""));
  create.set_sheet_id("demo");
  upload.mutable_sheet()->set_sheet_id("demo");
  upload.mutable_sheet()->mutable_scene()->set_sheet_id("lab-1");
  recording.set_sheet_id("demo");
  EXPECT_THAT(refusals(lab), ElementsAre("SHEET_NOT_ALLOWED", "SHEET_NOT_ALLOWED", "SHEET_NOT_ALLOWED"));
  EXPECT_EQ(refusal(check_access(lab, v1::BackupStoreRequest())), "SHEET_NOT_ALLOWED");
  EXPECT_TRUE(check_access(all, v1::BackupStoreRequest()).ok());
}

TEST(Access, DryRunsAreNotRecorded) {
  v1::CreateCutRequest cut;
  EXPECT_TRUE(is_recorded(cut));
  cut.set_validate_only(true);
  EXPECT_FALSE(is_recorded(cut));
  EXPECT_FALSE(is_recorded(v1::GetSheetRequest()));
}

class AccessApiTest : public ApiTest {
 protected:
  AccessApiTest() {
    authenticator_ = std::make_unique<auth::Authenticator>([this] { return now_; });
    authenticator_->set_tokens(auth::parse_token_file(alice_.line + "\n" + bob_.line).value().tokens);
    make_api({}, nullptr);
  }
  void be(const auth::NewToken& token) { caller_ = api_->caller_of("Bearer " + token.text, {}).value(); }
  Result<v1::AccessLink> link(v1::Scope scope, const std::string& sheet_id = {}, std::int32_t lifetime_s = 0) {
    v1::CreateLinkRequest request;
    request.set_scope(scope);
    request.set_sheet_id(sheet_id);
    request.set_lifetime_s(lifetime_s);
    return call(&Api::create_link, request);
  }

  std::int64_t now_ = 1'000'000;
  const auth::NewToken alice_ = auth::make_token({"alice", Scope::kCut, "", "", ""}).value();
  const auth::NewToken bob_ = auth::make_token({"bob", Scope::kView, "lab-*", "", ""}).value();
};

TEST_F(AccessApiTest, SaysWhatACallerMayDo) {
  EXPECT_EQ(api_->caller_of("", {}).error().reason, "TOKEN_MISSING");
  be(bob_);
  const v1::Access access = call(&Api::get_access, v1::GetAccessRequest()).value();
  EXPECT_TRUE(access.asks_for_tokens());
  EXPECT_EQ(access.token_id(), "bob");
  EXPECT_EQ(access.scope(), v1::SCOPE_VIEW);
  EXPECT_EQ(access.sheets(), "lab-*");
  EXPECT_EQ(access.expires_unix_s(), 0);
}

TEST_F(ApiTest, WithoutTokensEverybodyMayDoEverything) {
  const v1::Access access = call(&Api::get_access, v1::GetAccessRequest()).value();
  EXPECT_FALSE(access.asks_for_tokens());
  EXPECT_EQ(access.scope(), v1::SCOPE_ADMIN);
  EXPECT_EQ(call(&Api::create_link, v1::CreateLinkRequest()).error().reason, "NO_TOKENS");
}

TEST_F(AccessApiTest, ALinkGivesAPartOfWhatItsMakerHas) {
  be(alice_);
  const v1::AccessLink made = link(v1::SCOPE_UNSPECIFIED, "demo").value();
  EXPECT_EQ(made.path(), "/?sheet=demo#code=" + made.code());
  EXPECT_EQ(made.expires_unix_s(), now_ + 28'800);
  const std::string login = authenticator_->logins().open_link(made.code()).value();
  const auth::Caller guest = authenticator_->logins().find(login).value();
  EXPECT_EQ(guest->rights().scope, Scope::kView);
  EXPECT_EQ(guest->rights().sheets, "demo");
  EXPECT_EQ(guest->token_id(), "alice");
  EXPECT_EQ(link(v1::SCOPE_CUT).value().path().substr(0, 7), "/#code=");
  EXPECT_EQ(link(v1::SCOPE_ADMIN).error().reason, "SCOPE_TOO_LOW");
  EXPECT_EQ(link(static_cast<v1::Scope>(9)).error().field, "scope");
  EXPECT_EQ(link(v1::SCOPE_VIEW, "Demo").error().reason, "LINK_SHEET");
  for (const std::int32_t lifetime : {59, -1, 604'801}) {
    EXPECT_EQ(link(v1::SCOPE_VIEW, "", lifetime).error().reason, "LINK_LIFETIME");
  }
  for (const std::int32_t lifetime : {60, 604'800}) {
    EXPECT_EQ(link(v1::SCOPE_VIEW, "", lifetime).value().expires_unix_s(), now_ + lifetime);
  }
  be(bob_);
  EXPECT_EQ(link(v1::SCOPE_VIEW, "demo").error().reason, "LINK_SHEET") << "he does not reach it";
  // A guest's link ends with the guest's own login.
  caller_ = guest;
  EXPECT_EQ(link(v1::SCOPE_VIEW, "", 604'800).value().expires_unix_s(), made.expires_unix_s());
}

TEST_F(AccessApiTest, ListsHaveWhatTheCallerReaches) {
  for (const char* const id : {"a", "lab-1", "lab-2", "z"}) ASSERT_TRUE(create_sheet(id, true).ok());
  be(bob_);
  v1::ListSheetsRequest request;
  request.set_page_size(1);
  v1::ListSheetsResponse page = call(&Api::list_sheets, request).value();
  EXPECT_EQ(page.sheets(0).name(), "sheets/lab-1");
  request.set_page_token(page.next_page_token());
  page = call(&Api::list_sheets, request).value();
  ASSERT_EQ(page.sheets_size(), 1);
  EXPECT_EQ(page.sheets(0).name(), "sheets/lab-2");
  EXPECT_EQ(page.next_page_token(), "");
}

TEST_F(AccessApiTest, JsonCallsAskByThemselves) {
  ASSERT_TRUE(create_sheet("lab-1", true).ok());
  be(bob_);
  EXPECT_TRUE(call_json("/kerf.v1.SheetService/GetSheet", R"({"name":"sheets/lab-1"})").ok());
  EXPECT_EQ(call_json("/kerf.v1.SheetService/GetSheet", R"({"name":"sheets/a"})").error().reason, "SHEET_NOT_FOUND");
  EXPECT_EQ(call_json("/kerf.v1.SheetService/ResetSheet", R"({"name":"sheets/lab-1"})").error().reason,
            "SCOPE_TOO_LOW");
}

TEST_F(AccessApiTest, AStreamOfAViewerRejectsHandsAndEndsWithTheToken) {
  ASSERT_TRUE(create_sheet("lab-1", true).ok());
  be(bob_);
  const std::shared_ptr<WatchSession> session = api_->watch(caller_);
  v1::WatchRequest start;
  start.mutable_start()->set_name("sheets/lab-1");
  session->on_request(start);
  host_->wait_idle();
  ASSERT_TRUE(session->next()) << "the first frame";
  v1::WatchRequest grab;
  grab.mutable_grab()->set_grab_id("hand");
  session->on_request(grab);
  const std::optional<stream::Message> message = session->next();
  ASSERT_TRUE(message);
  v1::WatchResponse rejection;
  ASSERT_TRUE(rejection.ParseFromString(*message->parts.front()));
  EXPECT_EQ(rejection.rejection().grab_id(), "hand");
  EXPECT_FALSE(session->ended());
  authenticator_->set_tokens({});
  api_->check_callers();
  EXPECT_TRUE(session->ended());
  EXPECT_EQ(session->failure()->reason, "TOKEN_UNKNOWN");
}

TEST_F(AccessApiTest, StreamsWithoutATokenOrSheetFailAtOnce) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  EXPECT_EQ(api_->watch(api_->caller_of("", {}))->failure()->reason, "TOKEN_MISSING");
  EXPECT_EQ(api_->watch_images(api_->caller_of("Bearer x", {}))->failure()->reason, "TOKEN_UNKNOWN");
  be(bob_);
  v1::SubscribeRequest subscribe;
  subscribe.set_name("sheets/a");
  EXPECT_EQ(api_->subscribe(subscribe, caller_)->failure()->reason, "SHEET_NOT_FOUND");
  v1::WatchImagesStart play;
  play.set_name("sheets/a");
  EXPECT_EQ(api_->play_images(play, caller_)->failure()->reason, "SHEET_NOT_FOUND");
}

}  // namespace
}  // namespace kerf::api
