CREATE TABLE jobs (
    name TEXT PRIMARY KEY NOT NULL,
    place INTEGER,
    priority INTEGER NOT NULL,
    retries INTEGER NOT NULL,
    memory_limit INTEGER,
    started_in TEXT NOT NULL,
    scene TEXT NOT NULL,
    settings TEXT NOT NULL,
    arguments TEXT NOT NULL,
    state TEXT NOT NULL CHECK (state IN ('waiting', 'running', 'done', 'failed')),
    reason TEXT,
    program TEXT,
    passes INTEGER,
    seconds REAL,
    error REAL,
    error_bound REAL
) STRICT;
CREATE TABLE attempts (
    job TEXT NOT NULL REFERENCES jobs (name),
    number INTEGER NOT NULL,
    began TEXT NOT NULL,
    program TEXT NOT NULL,
    process INTEGER NOT NULL,
    threads INTEGER NOT NULL,
    load_seconds REAL,
    seconds REAL,
    outcome TEXT,
    reason TEXT,
    last_words TEXT,
    PRIMARY KEY (job, number)
) STRICT;
CREATE TABLE inputs (
    job TEXT NOT NULL REFERENCES jobs (name),
    path TEXT NOT NULL,
    hash TEXT,
    PRIMARY KEY (job, path)
) STRICT;
CREATE TABLE outputs (
    job TEXT NOT NULL REFERENCES jobs (name),
    path TEXT NOT NULL,
    hash TEXT NOT NULL,
    PRIMARY KEY (job, path)
) STRICT;
