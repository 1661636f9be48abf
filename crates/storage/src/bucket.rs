//! Files below an address, by the crate `object_store`.

use std::error::Error as _;
use std::io;
use std::time::Duration;

use object_store::aws::AmazonS3Builder;
use object_store::azure::MicrosoftAzureBuilder;
use object_store::gcp::GoogleCloudStorageBuilder;
use object_store::path::Path;
use object_store::{
    ClientOptions, Error as StoreError, ObjectStore, ObjectStoreExt as _, ObjectStoreScheme,
    RetryConfig,
};
use tokio::runtime::Runtime;
use touchdown_campaign::{Error, ObjectStorage, Result};
use url::Url;

/// A request that fails is sent again for so long. A server that is busy answers within seconds; one that is not there, or
/// credentials that nobody hands out, should not let a person wait for the library's three minutes.
const RETRIED_FOR: Duration = Duration::from_secs(20);

/// Connections are made within a second or two; half of this is too short for some mobile links.
const CONNECTED_WITHIN: Duration = Duration::from_secs(5);

/// What an address has to be.
const EXPECTED: &str =
    "a folder, or an address s3://bucket/name, gs://bucket/name or az://container/name";

/// Files below an address.
#[derive(Debug)]
pub struct Bucket {
    address: String,
    store: Box<dyn ObjectStore>,
    prefix: Path,
    runtime: Runtime,
}

impl Bucket {
    /// Files below an address. The environment says who asks, and where the server is; see the [crate](crate).
    ///
    /// # Errors
    /// An address of another kind, and variables that do not fit together. Nothing is sent yet.
    pub fn open(
        address: &str,
        environment: impl IntoIterator<Item = (String, String)>,
    ) -> Result<Self> {
        let bad = |found: &str| {
            Error::Arguments(format!("{address}: expected {EXPECTED}, found {found}"))
        };
        let url = Url::parse(address).map_err(|e| bad(&e.to_string()))?;
        // What an address is read as is what it says, or it is refused.
        if address.trim() != address
            || address.contains(['?', '#', '%', '@'])
            || url.port().is_some()
        {
            return Err(bad("a space at its ends, one of ?, #, % and @, or a port"));
        }
        if address.split('/').any(|part| part == "." || part == "..") {
            return Err(bad("`.` or `..` as a part"));
        }
        let known = ["s3", "gs", "az"].contains(&url.scheme());
        let parsed = ObjectStoreScheme::parse(&url);
        let (true, Ok((scheme, prefix))) = (known, parsed) else {
            return Err(bad("none of these"));
        };
        let environment = of_scheme(&scheme, environment)?;
        let store = client(&scheme, address, environment)
            .map_err(|e| Error::Arguments(format!("{address}: {}", in_words(&e))))?;
        Self::of(address, store, prefix)
    }

    fn of(address: &str, store: Box<dyn ObjectStore>, prefix: Path) -> Result<Self> {
        let address = address.trim_end_matches('/').to_owned();
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .map_err(|e| Error::file(std::path::Path::new(&address), e))?;
        Ok(Self {
            address,
            store,
            prefix,
            runtime,
        })
    }

    /// The key of a file.
    fn key(&self, name: &str) -> Path {
        name.split('/').fold(self.prefix.clone(), Path::join)
    }
}

/// End of the variable that names Google's server.
const BASE_URL: &str = "base_url";

/// The variables that are of a scheme, by their names in small letters. An empty one is none, as the scheme's own tools take it.
fn of_scheme(
    scheme: &ObjectStoreScheme,
    environment: impl IntoIterator<Item = (String, String)>,
) -> Result<Vec<(String, String)>> {
    let prefix = match scheme {
        ObjectStoreScheme::GoogleCloudStorage => "google_",
        ObjectStoreScheme::MicrosoftAzure => "azure_",
        _ => "aws_",
    };
    let mut own = Vec::new();
    for (name, value) in environment {
        let key = name.to_ascii_lowercase();
        if !key.starts_with(prefix) || value.is_empty() {
            continue;
        }
        // A key is not repeated.
        if value.contains(|c: char| c.is_control()) {
            return Err(Error::Arguments(format!(
                "{name}: expected a text on one line, found a line feed or another control character in it"
            )));
        }
        let is_server = Url::parse(&value)
            .is_ok_and(|url| ["http", "https"].contains(&url.scheme()) && url.host_str().is_some());
        let is_url = key.contains("endpoint") && key.contains("url") || key.ends_with(BASE_URL);
        if is_url && !is_server {
            return Err(Error::Arguments(format!(
                "{name}: expected a server such as https://host or http://host:9000, found {value}"
            )));
        }
        own.push((key, value));
    }
    Ok(own)
}

/// The client of a scheme.
fn client(
    scheme: &ObjectStoreScheme,
    address: &str,
    environment: Vec<(String, String)>,
) -> object_store::Result<Box<dyn ObjectStore>> {
    // A second one changes nothing, and is refused.
    let _ = rustls::crypto::ring::default_provider().install_default();
    let retry = RetryConfig {
        retry_timeout: RETRIED_FOR,
        // The time alone ends it.
        max_retries: 1000,
        ..RetryConfig::default()
    };
    // Whoever names a server without encryption wants it.
    let open = |(name, value): &(String, String)| {
        let names_server = name.contains("endpoint") || name.ends_with(BASE_URL);
        names_server && value.to_ascii_lowercase().starts_with("http://")
    };
    let options = ClientOptions::new()
        .with_connect_timeout(CONNECTED_WITHIN)
        .with_allow_http(environment.iter().any(open));
    // The builders share no trait.
    macro_rules! built {
        ($builder:ident) => {{
            let builder = $builder::new()
                .with_url(address)
                .with_client_options(options)
                .with_retry(retry);
            let builder =
                environment
                    .into_iter()
                    .fold(builder, |builder, (name, value)| match name.parse() {
                        Ok(key) => builder.with_config(key, value),
                        Err(_) => builder,
                    });
            Ok(Box::new(builder.build()?))
        }};
    }
    match scheme {
        ObjectStoreScheme::GoogleCloudStorage => built!(GoogleCloudStorageBuilder),
        ObjectStoreScheme::MicrosoftAzure => built!(MicrosoftAzureBuilder),
        _ => built!(AmazonS3Builder),
    }
}

impl ObjectStorage for Bucket {
    fn address(&self) -> &str {
        &self.address
    }

    fn names(&self, folder: &str) -> io::Result<Vec<String>> {
        let folder = self.key(folder);
        let listed = self.store.list_with_delimiter(Some(&folder));
        let listed = self.runtime.block_on(listed).map_err(|e| failed(&e))?;
        // Some consoles of S3 put an empty object in place of a folder.
        let files = listed.objects.iter().filter(|of| of.location != folder);
        let names = files.filter_map(|of| of.location.filename().map(str::to_owned));
        Ok(names.collect())
    }

    fn read(&self, name: &str) -> io::Result<Vec<u8>> {
        let key = self.key(name);
        let bytes = async { self.store.get(&key).await?.bytes().await };
        let bytes = self.runtime.block_on(bytes).map_err(|e| failed(&e))?;
        Ok(bytes.into())
    }

    fn write(&self, name: &str, bytes: Vec<u8>) -> io::Result<()> {
        let key = self.key(name);
        let put = self.store.put(&key, bytes.into());
        self.runtime.block_on(put).map_err(|e| failed(&e))?;
        Ok(())
    }

    fn remove(&self, name: &str) -> io::Result<()> {
        let key = self.key(name);
        match self.runtime.block_on(self.store.delete(&key)) {
            Err(StoreError::NotFound { .. }) => Ok(()),
            removed => removed.map_err(|e| failed(&e)),
        }
    }
}

/// A failed request as an error of input and output.
fn failed(error: &StoreError) -> io::Error {
    let kind = match error {
        StoreError::NotFound { .. } => io::ErrorKind::NotFound,
        StoreError::PermissionDenied { .. } | StoreError::Unauthenticated { .. } => {
            io::ErrorKind::PermissionDenied
        }
        _ => io::ErrorKind::Other,
    };
    io::Error::new(kind, in_words(error))
}

/// Where machines of Amazon, Azure and Google ask who they are. Asked where the environment has no key.
const ROLES: [&str; 2] = ["169.254.169.254", "metadata.google.internal"];

/// An error on one line: what the server says, or all that is behind the error. What an error repeats is said once.
fn in_words(error: &StoreError) -> String {
    let mut text = error.to_string();
    let mut behind = error.source();
    while let Some(error) = behind {
        let more = error.to_string();
        if !text.contains(&more) {
            text = format!("{text}: {more}");
        }
        behind = error.source();
    }
    if let (Some(code), Some(message)) = (element(&text, "Code"), element(&text, "Message")) {
        // Azure adds lines with the number and the time of the request.
        let message = message.lines().next().unwrap_or_default();
        return format!("the server says {code}: {message}");
    }
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    let text = before_page(&text).to_owned();
    match ROLES.iter().any(|role| text.contains(role)) {
        true => format!("found no key in the environment, and no role of this machine ({text})"),
        false => text,
    }
}

/// What stands before a page of HTML, with which proxies explain errors to browsers.
fn before_page(text: &str) -> &str {
    let lower = text.to_ascii_lowercase();
    let starts = ["<!doctype html", "<html"];
    let page = starts.iter().filter_map(|start| lower.find(start)).min();
    let words = page.map_or(text, |page| &text[..page]);
    words.trim_end_matches([' ', ':'])
}

/// The text of an element of XML, as servers explain errors.
fn element<'a>(text: &'a str, name: &str) -> Option<&'a str> {
    let (_, after) = text.split_once(&format!("<{name}>"))?;
    let (inside, _) = after.split_once(&format!("</{name}>"))?;
    Some(inside)
}

#[cfg(test)]
mod tests {
    use super::*;
    use object_store::memory::InMemory;
    use proptest::prelude::*;
    use std::collections::BTreeMap;

    fn in_memory(prefix: &str) -> Bucket {
        Bucket::of(
            "s3://bucket/prefix/",
            Box::new(InMemory::new()),
            prefix.into(),
        )
        .unwrap()
    }

    proptest! {
        /// Object storage holds what a map from names to bytes holds.
        #[test]
        fn prop_files_are_those_that_were_written(
            steps in prop::collection::vec(
                (0..2_u8, "(a|b|c/d|c/e|c/f/g)", prop::collection::vec(any::<u8>(), 0..9)),
                0..12,
            ),
            prefix in "(|p|p/q)",
        ) {
            let bucket = in_memory(&prefix);
            let mut files = BTreeMap::new();
            for (kind, name, bytes) in steps {
                if kind == 0 {
                    bucket.remove(&name).unwrap();
                    files.remove(&name);
                } else {
                    bucket.write(&name, bytes.clone()).unwrap();
                    files.insert(name, bytes);
                }
            }
            for name in ["a", "b", "c/d", "c/e", "c/f/g"] {
                match files.get(name) {
                    Some(bytes) => prop_assert_eq!(&bucket.read(name).unwrap(), bytes),
                    None => prop_assert_eq!(bucket.read(name).unwrap_err().kind(), io::ErrorKind::NotFound),
                }
            }
            let mut names = bucket.names("c").unwrap();
            names.sort();
            let expected: Vec<&str> = ["d", "e"].into_iter().filter(|n| files.contains_key(&format!("c/{n}"))).collect();
            prop_assert_eq!(names, expected);
        }
    }

    #[test]
    fn prop_addresses_of_other_kinds_are_refused() {
        for address in [
            "s3:///name",
            "ftp://host/name",
            "https://host/name",
            "file:///tmp/name",
            "memory:///name",
            "s3://bucket/name?version=1",
            "s3://bucket/a//b",
            " s3://bucket/a",
            "s3:/bucket/a",
            "s3://bucket/../a",
            "s3://bucket/./a",
            "s3://bucket/a%20b",
            "s3://localhost:9000/bucket",
            "s3://user:key@bucket/a",
        ] {
            let error = Bucket::open(address, []).unwrap_err();
            assert_eq!(error.exit_status(), 2, "{address}");
            let error = error.to_string();
            assert!(
                error.contains("expected a folder, or an address"),
                "{error}"
            );
        }
        let bucket = Bucket::open("s3://bucket/some/name/", []).unwrap();
        assert_eq!(bucket.address(), "s3://bucket/some/name");
        assert_eq!(bucket.key("c/d").as_ref(), "some/name/c/d");
        for address in ["s3://bucket", "gs://bucket/name"] {
            Bucket::open(address, []).unwrap();
        }
    }

    #[test]
    fn prop_variables_that_cannot_be_are_named() {
        let of = |name: &str, value: &str| {
            let environment = [(name.to_owned(), value.to_owned())];
            let address = match name.starts_with("GOOGLE_BASE") {
                true => "gs://bucket/a",
                false => "s3://bucket/a",
            };
            Bucket::open(address, environment).map(drop)
        };
        for (name, value) in [
            ("GOOGLE_BASE_URL", "127.0.0.1:9023"),
            ("AWS_ENDPOINT_URL", "127.0.0.1:9000"),
            ("AWS_ENDPOINT_URL", "nonsense"),
            ("AWS_ENDPOINT_URL_S3", "ftp://host"),
            ("AWS_ACCESS_KEY_ID", "a\n"),
        ] {
            let error = of(name, value).unwrap_err();
            assert_eq!(error.exit_status(), 2);
            assert!(
                error.to_string().starts_with(&format!("{name}: expected ")),
                "{error}"
            );
        }
        for (name, value) in [
            ("AWS_ENDPOINT_URL", ""),
            ("AWS_ENDPOINT_URL", "HTTP://127.0.0.1:9000"),
            ("GOOGLE_APPLICATION_CREDENTIALS", "nowhere\n"),
            ("ENDPOINT_URL", "nonsense"),
        ] {
            of(name, value).unwrap();
        }
    }

    #[test]
    fn prop_an_empty_object_in_place_of_a_folder_is_no_file() {
        let bucket = in_memory("p");
        bucket.write("landings", Vec::new()).unwrap();
        bucket.write("landings/a", vec![1]).unwrap();
        let listed = bucket.names("landings").unwrap();
        assert_eq!(listed, ["a"]);
    }

    #[test]
    fn prop_an_error_says_what_the_server_says_or_that_there_is_no_key() {
        let of = |text: &str| {
            in_words(&StoreError::Generic {
                store: "S3",
                source: text.into(),
            })
        };
        let body = "404 Not Found: <Error><Code>NoSuchBucket</Code>\n<Message>It is not there\nTime:1</Message></Error>";
        assert_eq!(of(body), "the server says NoSuchBucket: It is not there");
        let role = of("GET http://169.254.169.254/latest: timed\nout");
        assert!(
            role.starts_with("found no key in the environment"),
            "{role}"
        );
        assert!(!role.contains('\n'), "{role}");
        assert_eq!(of("away"), "Generic S3 error: away");
        let empty = "501 Not Implemented: ";
        assert_eq!(of(empty), "Generic S3 error: 501 Not Implemented");
        let page = "502 Bad Gateway: <!DOCTYPE HTML>\n<html><body>Sorry</body></html>";
        assert_eq!(of(page), "Generic S3 error: 502 Bad Gateway");
    }
}
