CREATE TABLE IF NOT EXISTS job (
    id INTEGER PRIMARY KEY AUTOINCREMENT,
    name TEXT NOT NULL,
    owner TEXT NOT NULL,
    state TEXT NOT NULL,
    priority INTEGER NOT NULL,
    workers INTEGER NOT NULL,
    launcher TEXT NOT NULL,
    main TEXT NOT NULL,
    sets TEXT NOT NULL,
    later_sets TEXT NOT NULL DEFAULT '[]',
    retries INTEGER NOT NULL,
    check_only INTEGER NOT NULL DEFAULT 0,
    memory_mb REAL NOT NULL DEFAULT 0,
    submitted REAL NOT NULL,
    started REAL,
    ended REAL,
    code INTEGER,
    reason TEXT NOT NULL DEFAULT '',
    attempt INTEGER NOT NULL DEFAULT 0,
    handle TEXT NOT NULL DEFAULT '',
    lost INTEGER NOT NULL DEFAULT 0,
    stopping INTEGER NOT NULL DEFAULT 0
);
CREATE INDEX IF NOT EXISTS job_state ON job (state, priority DESC, id);
CREATE INDEX IF NOT EXISTS job_owner ON job (owner);
CREATE TABLE IF NOT EXISTS event (
    id INTEGER PRIMARY KEY AUTOINCREMENT,
    job INTEGER NOT NULL,
    at REAL NOT NULL,
    kind TEXT NOT NULL,
    data TEXT NOT NULL
);
CREATE INDEX IF NOT EXISTS event_job ON event (job, id);
CREATE TABLE IF NOT EXISTS token (
    name TEXT PRIMARY KEY,
    role TEXT NOT NULL,
    hash TEXT NOT NULL UNIQUE,
    made REAL NOT NULL
);
CREATE TABLE IF NOT EXISTS audit (
    id INTEGER PRIMARY KEY AUTOINCREMENT,
    at REAL NOT NULL,
    who TEXT NOT NULL,
    what TEXT NOT NULL,
    job INTEGER,
    detail TEXT NOT NULL,
    status INTEGER NOT NULL
);
