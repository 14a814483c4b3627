/* Calls everything in catan.h, in C: `session APP` the session's part, `client`, under `catan run`, the client's. */
#define _POSIX_C_SOURCE 200809L
#include "c_api_test.h"

#include <catan/catan.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

void nap(int milliseconds) {
  struct timespec time;
  time.tv_sec = milliseconds / 1000;
  time.tv_nsec = (long)(milliseconds % 1000) * 1000000L;
  nanosleep(&time, NULL);
}

static void test_version(void) {
  char text[32];
  const unsigned version = (unsigned)catan_version();
  CHECK(catan_version() == CATAN_VERSION);
  snprintf(text, sizeof text, "%u.%u.%u", version / 10000, version / 100 % 100, version % 100);
  CHECK(strcmp(text, PROJECT_VERSION) == 0);
}

static void test_errors(const char* app) {
  catan_error* error = NULL;
  catan_client_options options = CATAN_CLIENT_OPTIONS;
  catan_session_options session_options = CATAN_SESSION_OPTIONS;
  CHECK(catan_session_open("/nowhere/app.yaml", NULL, &error) == NULL);
  CHECK(error != NULL);
  CHECK(catan_error_status(error) == CATAN_CALLER || catan_error_status(error) == CATAN_ENVIRONMENT);
  CHECK(strstr(catan_error_message(error), "/nowhere/app.yaml") != NULL);
  catan_error_free(error);
  error = NULL;
  CHECK(catan_session_open("/nowhere/app.yaml", NULL, NULL) == NULL);
  CHECK(catan_session_open(NULL, NULL, &error) == NULL);
  CHECK(catan_error_status(error) == CATAN_CALLER);
  catan_error_free(error);
  error = NULL;
  options.socket = "/nowhere/catan.sock";
  options.wait_seconds = -1.0;
  CHECK(catan_client_connect(&options, &error) == NULL);
  CHECK(catan_error_status(error) == CATAN_ENVIRONMENT);
  CHECK(strstr(catan_error_message(error), "/nowhere/catan.sock") != NULL);
  catan_error_free(error);
  error = NULL;
  /* Options that do not say how large they are. */
  memset(&options, 0, sizeof options);
  CHECK(catan_client_connect(&options, &error) == NULL);
  CHECK(catan_error_status(error) == CATAN_CALLER);
  CHECK(strstr(catan_error_message(error), "begin with CATAN_CLIENT_OPTIONS") != NULL);
  catan_error_free(error);
  error = NULL;
  memset(&session_options, 0, sizeof session_options);
  CHECK(catan_session_open(app, &session_options, &error) == NULL);
  CHECK(catan_error_status(error) == CATAN_CALLER);
  CHECK(strstr(catan_error_message(error), "begin with CATAN_SESSION_OPTIONS") != NULL);
  catan_error_free(error);
  /* What is NULL is an error, or nothing. */
  CHECK(catan_session_start(NULL, NULL) == CATAN_CALLER);
  CHECK(catan_session_stop(NULL, NULL) == CATAN_CALLER);
  CHECK(catan_session_snapshot(NULL, NULL) == NULL);
  CHECK(catan_session_adopt_this_thread(NULL, NULL, NULL) == CATAN_CALLER);
  CHECK(catan_client_start(NULL, NULL) == CATAN_CALLER);
  CHECK(catan_client_attach(NULL, NULL, NULL) == NULL);
  CHECK(catan_client_adopt_this_thread(NULL, NULL, NULL) == CATAN_CALLER);
  CHECK(catan_client_served(NULL) == 0);
  CHECK(catan_error_status(NULL) == CATAN_OK);
  CHECK(strcmp(catan_error_message(NULL), "") == 0);
  catan_session_node(NULL, NULL, NULL, NULL);
  catan_client_node(NULL, NULL, NULL, NULL);
  catan_client_stop(NULL);
  catan_session_free(NULL);
  catan_client_free(NULL);
  catan_error_free(NULL);
  catan_free(NULL);
}

static void test_mistakes_are_told_by_start(const char* app) {
  catan_error* error = NULL;
  catan_session* session = catan_session_open(app, NULL, &error);
  CHECK(session != NULL);
  catan_session_node(session, "nobody", NULL, NULL);
  CHECK(catan_session_start(session, &error) == CATAN_CALLER);
  CHECK(strstr(catan_error_message(error), "nobody") != NULL);
  CHECK(strstr(catan_error_message(error), "sense") != NULL); /* has no function */
  catan_error_free(error);
  catan_session_free(session);
}

/* A record, which is a file of SQLite, and a new one: what is there already is not overwritten. */
static void test_save_flight(const catan_session* session) {
  char folder[] = "/tmp/c_api_test.XXXXXX";
  char path[sizeof folder + 16];
  char start[16] = "";
  catan_error* error = NULL;
  FILE* file;
  CHECK(mkdtemp(folder) != NULL);
  snprintf(path, sizeof path, "%s/saved.catan", folder);
  CHECK(catan_session_save_flight(NULL, path, "a test", NULL) == CATAN_CALLER);
  CHECK(catan_session_save_flight(session, NULL, "a test", NULL) == CATAN_CALLER);
  CHECK(catan_session_save_flight(session, "/nowhere/saved.catan", NULL, &error) != CATAN_OK);
  CHECK(strstr(catan_error_message(error), "/nowhere/saved.catan") != NULL);
  catan_error_free(error);
  error = NULL;
  CHECK(catan_session_save_flight(session, path, "a test", &error) == CATAN_OK);
  CHECK(error == NULL);
  CHECK(catan_session_save_flight(session, path, NULL, NULL) == CATAN_CALLER);
  file = fopen(path, "rb");
  CHECK(file != NULL && fread(start, 1, sizeof start, file) == sizeof start);
  CHECK(memcmp(start, "SQLite format 3", sizeof start) == 0);
  fclose(file);
  CHECK(remove(path) == 0);
  CHECK(remove(folder) == 0);
}

struct counts {
  volatile int sensed;
  volatile int acted;
  volatile int ticks;
  volatile int notices;
};

static void sense(catan_run* run, void* user) {
  struct counts* counts = user;
  ++counts->sensed;
  CHECK(catan_run_number(run) == (uint64_t)counts->sensed);
  CHECK(catan_run_threads(run) == 1);
  CHECK(catan_run_stale(run) == 0);
  if (counts->sensed % 2 == 0) catan_run_skip_output(run);
}

static void act(catan_run* run, void* user) {
  struct counts* counts = user;
  ++counts->acted;
  catan_run_set_mode(run, (uint32_t)(counts->acted % 2));
  CHECK(catan_run_age_ns(run, "sense") > 1 && catan_run_age_ns(run, "sense") < 100000000000);
  CHECK(catan_run_age_ns(run, "nobody") == CATAN_NO_INPUT);
  CHECK(catan_run_age_ns(run, NULL) == CATAN_NO_INPUT);
  CHECK(catan_run_stale(run) != 0); /* nothing is that young */
}

static void tick(catan_run* run, void* user) {
  (void)run;
  ++((struct counts*)user)->ticks;
}

static void on_notice(const char* text, void* user) {
  CHECK(text[0] != '\0');
  ++((struct counts*)user)->notices;
}

static void test_session(const char* app) {
  struct counts counts = {0, 0, 0, 0};
  catan_error* error = NULL;
  catan_session_options options = CATAN_SESSION_OPTIONS;
  catan_session* session;
  char* snapshot;
  options.frames = 3;
  CHECK(catan_session_open(app, &options, NULL) == NULL);
  options.frames = 0;
  options.policy = "rate:50Hz";
  options.on_notice = on_notice;
  options.on_notice_user = &counts;
  session = catan_session_open(app, &options, &error);
  if (session == NULL) fprintf(stderr, "%s\n", catan_error_message(error));
  CHECK(session != NULL);
  catan_session_node(session, "sense", sense, &counts);
  catan_session_node(session, "act", act, &counts);
  catan_session_node(session, "clock", tick, &counts);
  CHECK(catan_session_start(session, &error) == CATAN_OK);
  CHECK(error == NULL);
  CHECK(catan_session_adopt_this_thread(session, "nobody", NULL) == CATAN_CALLER);
  CHECK(catan_session_adopt_this_thread(session, "act", &error) == CATAN_OK);
  nap(1500);
  snapshot = catan_session_snapshot(session, &error);
  CHECK(snapshot != NULL);
  CHECK(strstr(snapshot, "\"policy\":\"rate:50Hz\"") != NULL || strstr(snapshot, "\"policy\":\"rate:50") != NULL);
  CHECK(strstr(snapshot, "\"path\":[\"sense\",\"act\"]") != NULL);
  CHECK(strstr(snapshot, "\"name\":\"clock\"") != NULL);
  CHECK(strstr(snapshot, "\"starved_ms\":") != NULL);
  CHECK(strstr(snapshot, "\"ages\":[{\"from\":\"sense\",\"to\":\"act\"") != NULL);
  CHECK(strstr(snapshot, "stale-input: what act takes from sense is") != NULL);
  CHECK(strstr(snapshot, "\"relax_factor\":1.0,\"relaxed\":[]") != NULL);
  CHECK(strstr(snapshot, "\"assumed\":[") != NULL);
  catan_free(snapshot);
  test_save_flight(session);
  CHECK(catan_session_stop(session, &error) == CATAN_OK);
  CHECK(counts.sensed >= 10 && counts.sensed <= 90);
  CHECK(abs(2 * counts.acted - counts.sensed) <= 2);
  CHECK(counts.ticks > counts.sensed);
  CHECK(catan_session_stop(session, &error) == CATAN_OK);
  catan_session_free(session);
}

static void test_changes(const char* app) {
  struct counts counts = {0, 0, 0, 0};
  catan_error* error = NULL;
  catan_session* session = catan_session_open(app, NULL, &error);
  const int nowhere = 1 << 20;
  char* snapshot;
  CHECK(session != NULL);
  CHECK(catan_session_set_weight(NULL, "0", 1.0, NULL) == CATAN_CALLER);
  CHECK(catan_session_set_weight(session, "0", 1.0, NULL) == CATAN_CALLER); /* it does not run */
  catan_session_node(session, "sense", sense, &counts);
  catan_session_node(session, "act", act, &counts);
  catan_session_node(session, "clock", tick, &counts);
  CHECK(catan_session_start(session, &error) == CATAN_OK);
  CHECK(catan_session_set_weight(session, "0", 7.5, &error) == CATAN_OK);
  CHECK(catan_session_set_max(session, "sense -> act", 900.0, &error) == CATAN_OK);
  CHECK(catan_session_set_min_rate(session, "act", 2.0, &error) == CATAN_OK);
  CHECK(error == NULL);
  CHECK(catan_session_tick(session, "screen", 1000000, &error) == CATAN_OK);
  CHECK(catan_session_tick(NULL, "screen", 1000000, NULL) == CATAN_CALLER);
  CHECK(catan_session_tick(session, "act", 1000000, NULL) == CATAN_CALLER);
  CHECK(catan_session_tick(session, NULL, 1000000, NULL) == CATAN_CALLER);
  CHECK(catan_session_set_cpus(session, NULL, 0, NULL) == CATAN_CALLER);
  CHECK(catan_session_set_cpus(session, &nowhere, 1, NULL) == CATAN_CALLER);
  CHECK(catan_session_set_max(session, NULL, 1.0, &error) == CATAN_CALLER);
  CHECK(strstr(catan_error_message(error), "no such term") != NULL);
  catan_error_free(error);
  error = NULL;
  nap(200);
  snapshot = catan_session_snapshot(session, &error);
  CHECK(strstr(snapshot, "\"changes\":3,") != NULL);
  CHECK(strstr(snapshot, "\"weight\":7.5,\"max_ms\":900.0") != NULL);
  CHECK(strstr(snapshot, "\"min_rate_hz\":2.0") != NULL);
  catan_free(snapshot);
  CHECK(catan_session_set_max(session, "0", 0.0, &error) == CATAN_OK);
  CHECK(catan_session_stop(session, &error) == CATAN_OK);
  catan_session_free(session);
}

/* A program that was built when the options had fewer fields: the rest have their defaults. */
static void test_shorter_options(const char* app) {
  catan_session_options options = CATAN_SESSION_OPTIONS;
  catan_session* session;
  options.size = offsetof(catan_session_options, frames);
  options.frames = 99;
  session = catan_session_open(app, &options, NULL);
  CHECK(session != NULL);
  catan_session_free(session);
}

int main(int argc, char** argv) {
  if (argc == 2 && strcmp(argv[1], "client") == 0) return test_client();
  if (argc != 3 || strcmp(argv[1], "session") != 0) return 2;
  test_version();
  test_errors(argv[2]);
  test_mistakes_are_told_by_start(argv[2]);
  test_session(argv[2]);
  test_changes(argv[2]);
  test_shorter_options(argv[2]);
  return 0;
}
