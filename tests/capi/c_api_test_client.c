/* The client's part: three nodes of one app in one process, two called, one attached. */
#define _POSIX_C_SOURCE 200809L
#include <catan/catan.h>
#include <pthread.h>
#include <string.h>

#include "c_api_test.h"

struct counts {
  volatile int sensed;
  volatile int ticks;
  volatile int acted;
};

static catan_client* client;

static void sense(catan_run* run, void* user) {
  ++((struct counts*)user)->sensed;
  CHECK(catan_run_number(run) > 0);
}

static void tick(catan_run* run, void* user) {
  (void)run;
  ++((struct counts*)user)->ticks;
}

static void* act(void* user) {
  struct counts* counts = user;
  catan_error* error = NULL;
  catan_node* node = catan_client_attach(client, "act", &error);
  if (node == NULL) fprintf(stderr, "%s\n", catan_error_message(error));
  CHECK(node != NULL);
  while (catan_node_wait(node)) {
    catan_run* run = catan_node_begin(node);
    ++counts->acted;
    catan_run_set_mode(run, 1);
    CHECK(catan_run_age_ns(run, "sense") > 1);
    CHECK(catan_run_age_ns(run, "nobody") == CATAN_NO_INPUT);
    CHECK(catan_run_stale(run) != 0);
    catan_node_end(node);
  }
  return NULL;
}

static void* help(void* user) {
  (void)user;
  CHECK(catan_client_adopt_this_thread(client, "act", NULL) == CATAN_OK);
  nap(300);
  return NULL;
}

int test_client(void) {
  struct counts counts = {0, 0, 0};
  catan_error* error = NULL;
  catan_client_options options = CATAN_CLIENT_OPTIONS;
  pthread_t actor;
  pthread_t helper;
  int waited = 0;
  options.app = "another";
  CHECK(catan_client_connect(&options, &error) == NULL);
  CHECK(strstr(catan_error_message(error), "c_api") != NULL);
  catan_error_free(error);
  error = NULL;
  options.app = "c_api";
  client = catan_client_connect(&options, &error);
  CHECK(client != NULL);
  catan_client_node(client, "sense", sense, &counts);
  catan_client_node(client, "clock", tick, &counts);
  CHECK(catan_client_start(client, &error) == CATAN_OK);
  CHECK(catan_client_served(client) == 1);
  CHECK(catan_client_attach(client, "nobody", &error) == NULL);
  CHECK(catan_error_status(error) == CATAN_CALLER);
  catan_error_free(error);
  error = NULL;
  CHECK(catan_client_adopt_this_thread(client, "act", NULL) != CATAN_OK); /* which nobody runs yet */
  CHECK(pthread_create(&actor, NULL, act, &counts) == 0);
  while (counts.acted < 20 && ++waited < 1000) nap(10);
  CHECK(counts.acted >= 20);
  CHECK(counts.sensed >= 20);
  CHECK(counts.ticks >= 20);
  CHECK(pthread_create(&helper, NULL, help, NULL) == 0);
  CHECK(pthread_join(helper, NULL) == 0);
  catan_client_stop(client);
  CHECK(pthread_join(actor, NULL) == 0);
  catan_client_free(client);
  return 0;
}
