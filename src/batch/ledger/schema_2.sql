ALTER TABLE attempts ADD COLUMN peak_memory INTEGER;
CREATE TABLE batches (
    number INTEGER PRIMARY KEY NOT NULL,
    began TEXT NOT NULL,
    program TEXT NOT NULL,
    jobs_at_once INTEGER,
    threads_each INTEGER,
    measured TEXT,
    outcome TEXT
) STRICT;
