/* Catan for other languages: the C ABI over ctn::Session (an app in one process) and ctn::Client (nodes that `catan
 * serve` schedules, in a process of their own). session.h and client.h say what the calls mean; here stands what
 * differs.
 *
 *   catan_error* error = NULL;
 *   catan_client* client = catan_client_connect(NULL, &error);
 *   if (client == NULL) { fprintf(stderr, "%s\n", catan_error_message(error)); return 1; }
 *   catan_client_node(client, "detect", look, NULL);
 *   catan_client_start(client, &error);
 *
 * Library: libcatan.so; `pkg-config catan`, or find_package(catan COMPONENTS c) and catan::c. C99, and C++.
 *
 * Errors. A call that can fail takes `catan_error** error`, which may be NULL. On failure, and only then, it stores an
 * error there that the caller owns (catan_error_free). Calls that return a catan_status return CATAN_OK, which is 0, or
 * what kind of error it was; calls that return a pointer return NULL. No C++ exception leaves a call. None may enter:
 * a function that is called back must return, neither throw nor jump out; else the process ends.
 *
 * Ownership. Handles are owned by the caller who got them, and freed by the function named *_free, which accepts NULL.
 * Strings that go in are copied. Strings that come out belong to the object that they came from, but for
 * catan_session_snapshot().
 *
 * Data. Channels are C++ templates, so they are not here: values travel between nodes by means of your own. A run is
 * taken to have consumed what its predecessors had given when it began: the newest output of each, or with `input:
 * queue` all since the run before. An exchange of your own must be safe between threads; hold a lock in it
 * no longer than a copy takes, since nodes have different priorities.
 *
 * Thread safety. Calls on different handles are independent. For one handle: as the C++ classes say, repeated below. */
#pragma once

/* NOLINTBEGIN(readability-identifier-naming,modernize-use-using,modernize-redundant-void-arg): this is C */
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Of this header. catan_version() is that of the library that was loaded: compare major and minor, which agree where
 * both fit each other. */
#define CATAN_VERSION_MAJOR 0
#define CATAN_VERSION_MINOR 1
#define CATAN_VERSION_PATCH 0
#define CATAN_VERSION (CATAN_VERSION_MAJOR * 10000 + CATAN_VERSION_MINOR * 100 + CATAN_VERSION_PATCH)
uint32_t catan_version(void);

/* --- Errors --- */

/* The numbers are those that the command exits with. */
typedef int catan_status;
enum {
  CATAN_OK = 0,
  CATAN_ENVIRONMENT = 1, /* the machine said no: a missing permission, a full disk, no server, no memory */
  CATAN_CALLER = 2,      /* the caller's mistake, which includes NULL where something is required */
  CATAN_BUG = 3          /* a fault in Catan: please report it */
};

typedef struct catan_error catan_error;
/* All that was wrong, one problem a line, without a newline at the end. Valid until the error is freed. */
const char* catan_error_message(const catan_error* error);
catan_status catan_error_status(const catan_error* error);
void catan_error_free(catan_error* error);

/* --- A node's run --- */

/* One execution of a node. Valid during the call that got it, or between begin and end; used by that thread alone. */
typedef struct catan_run catan_run;
uint64_t catan_run_number(const catan_run* run); /* counts from 1 */
/* On how many threads the run should work, the node's own included; more gain nothing. */
int catan_run_threads(const catan_run* run);
/* The run's mode, an index into `modes` of the app file; 0 if it is not set. */
void catan_run_set_mode(catan_run* run, uint32_t mode);
/* The run gives no output: successors are not triggered. */
void catan_run_skip_output(catan_run* run);
/* How old what the run takes from node `input` was when the run began, in nanoseconds: the time since the begin of the
 * oldest source run that it goes back to. CATAN_NO_INPUT, which is more than any limit: nothing has come from there
 * yet, or the node has no such input. */
#define CATAN_NO_INPUT INT64_MAX
int64_t catan_run_age_ns(catan_run* run, const char* input);
/* Not 0: an input is older than its edge's `max_age` in the app file. With `on_stale: skip` the run gives no output. */
int catan_run_stale(catan_run* run);

/* Called once a run, from a thread that Catan makes. `user` is what was given with the function. */
typedef void (*catan_node_function)(catan_run* run, void* user);
/* Called from a thread at the ordinary level, one call at a time for one handle; may block, may not free the handle. */
typedef void (*catan_notice_function)(const char* text, void* user);

/* --- A session: an app in one process --- */

/* Fields that are 0 or NULL have their defaults. Begin with CATAN_SESSION_OPTIONS; later versions add fields at the
 * end, and `size` tells which of them the caller knows. One that is that of no version, such as 0, is an error
 * (CATAN_CALLER). */
typedef struct catan_session_options {
  size_t size;        /* of this struct */
  const char* policy; /* "catan" */
  const int* cpus;    /* CPUs that nodes may use; NULL: all that this process may use */
  size_t cpu_count;
  const char* record; /* path of the record to write; NULL: none */
  const char* note;   /* kept in the record */
  int no_stealing;    /* not 0: no unfinished subchain goes on in another's slot */
  int no_replan;      /* not 0: the first plan from measured times stays */
  int frames;         /* 0: as the app file says; 1: elastic; 2: fixed */
  catan_notice_function on_notice;
  void* on_notice_user;
  int flight_recorder_mib; /* memory in which the last seconds are kept; 0: 8, less: they are not */
} catan_session_options;
#define CATAN_SESSION_OPTIONS \
  { sizeof(catan_session_options), NULL, NULL, 0, NULL, NULL, 0, 0, 0, NULL, NULL, 0 }

/* Thread safety: one thread at a time; set_..., snapshot and adopt_this_thread from any. */
typedef struct catan_session catan_session;
/* `options` may be NULL. */
catan_session* catan_session_open(const char* app_file, const catan_session_options* options, catan_error** error);
/* Mistakes in it (a name that the app has not, a second function) are told by start, all at once. */
void catan_session_node(catan_session* session, const char* name, catan_node_function function, void* user);
catan_status catan_session_start(catan_session* session, catan_error** error);
/* The calling thread works for the node from now on, in addition to the node's own. */
catan_status catan_session_adopt_this_thread(catan_session* session, const char* node, catan_error** error);
/* The clock of an external node with a period (a display, say) ticked, at that time of CLOCK_MONOTONIC: chains that end
 * or begin there are measured by its ticks. From any thread, but for one node from one at a time. */
catan_status catan_session_tick(catan_session* session, const char* node, int64_t monotonic_ns, catan_error** error);
/* While it runs: from now on it uses these CPUs, of those that it was given; an objective's term has this weight or,
 * for response times, this bound; a node has this lowest rate (0: no bound). Terms are named as in changes.h: "0",
 * "scan -> LM". A plan follows at once. What is wrong changes nothing. From any thread. */
catan_status catan_session_set_cpus(catan_session* session, const int* cpus, size_t count, catan_error** error);
catan_status catan_session_set_weight(catan_session* session, const char* term, double weight, catan_error** error);
catan_status catan_session_set_max(catan_session* session, const char* term, double max_ms, catan_error** error);
catan_status catan_session_set_min_rate(catan_session* session, const char* node, double hertz, catan_error** error);
/* What was measured so far, as one JSON object: the fields of ctn::Snapshot (snapshot.h) under their names. The caller
 * frees it with catan_free(). NULL on failure. */
char* catan_session_snapshot(const catan_session* session, catan_error** error);
/* Saves the last seconds, which are kept in memory, as a new record; `why` (NULL: "asked") is told in it. */
catan_status catan_session_save_flight(const catan_session* session, const char* path, const char* why,
                                       catan_error** error);
/* Waits for runs that are under way; no function is called afterwards. May be called twice. An error that does nothing
 * from a function that the session calls. */
catan_status catan_session_stop(catan_session* session, catan_error** error);
/* Stops it first. Not from a function that the session calls. */
void catan_session_free(catan_session* session);
void catan_free(void* memory);

/* --- A client: nodes of an app that a server schedules --- */

/* As those of a session; begin with CATAN_CLIENT_OPTIONS. */
typedef struct catan_client_options {
  size_t size;         /* of this struct */
  const char* socket;  /* of the server; NULL: what CATAN_SOCKET names, else the usual one of `app` */
  const char* app;     /* name of the app; checked, if given */
  double wait_seconds; /* for a server that is not there yet; 0: ten seconds. Less than 0: do not wait */
  catan_notice_function on_notice;
  void* on_notice_user;
} catan_client_options;
#define CATAN_CLIENT_OPTIONS \
  { sizeof(catan_client_options), NULL, NULL, 0.0, NULL, NULL }

/* Thread safety: connect, node, start, stop, free from one thread; attach and adopt_this_thread from the thread
 * concerned, between start and stop; served from any. */
typedef struct catan_client catan_client;
/* `options` may be NULL. */
catan_client* catan_client_connect(const catan_client_options* options, catan_error** error);
/* Mistakes in it are told by start, all at once. */
void catan_client_node(catan_client* client, const char* name, catan_node_function function, void* user);
catan_status catan_client_start(catan_client* client, catan_error** error);
catan_status catan_client_adopt_this_thread(catan_client* client, const char* node, catan_error** error);
/* Not 0: a server is there at this moment. */
int catan_client_served(const catan_client* client);
/* Ends waits and lets functions that are under way return. Attached threads are to return by themselves. From a
 * function that the client calls it returns at once, and what it does follows when that has returned. */
void catan_client_stop(catan_client* client);
/* Stops it first. By then, no attached thread may use its node any more. */
void catan_client_free(catan_client* client);

/* A node whose runs its own thread begins and ends:
 *   while (catan_node_wait(node)) { catan_run* run = catan_node_begin(node); ...; catan_node_end(node); }
 * It belongs to its client and lives as long as that. */
typedef struct catan_node catan_node;
/* The calling thread becomes the node's. */
catan_node* catan_client_attach(catan_client* client, const char* name, catan_error** error);
/* Blocks until the node is to run; 0: the client was stopped. An unscheduled node waits only if it has no period of its
 * own, for the output of the node that it follows. */
int catan_node_wait(catan_node* node);
catan_run* catan_node_begin(catan_node* node);
void catan_node_end(catan_node* node);

#ifdef __cplusplus
}
#endif
/* NOLINTEND(readability-identifier-naming,modernize-use-using,modernize-redundant-void-arg) */
